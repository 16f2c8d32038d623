#include "anatomesh/pipeline/model_warnings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace anatomesh {
namespace {

std::size_t warnings_of_distance(double max_mm, bool at_least, std::uint64_t points = 10) {
    ModelReport report;
    report.field_distance.points = points;
    report.field_distance.max_mm = max_mm;
    report.field_distance.at_least = at_least;
    RunContext context;
    warn_of_model(report, 2.0, "drawn.json", context);
    std::size_t count = 0;
    for (const Warning& warning : context.warnings) count += warning.code == "W-PIP-008";
    return count;
}

TEST(ModelWarnings, a_surface_far_from_the_field) {
    EXPECT_EQ(warnings_of_distance(1.1, false), 1u);
    EXPECT_EQ(warnings_of_distance(0.9, false), 0u);
    // The field tells no more than this: it may be any distance.
    EXPECT_EQ(warnings_of_distance(0.5, true), 1u);
    EXPECT_EQ(warnings_of_distance(3, true, 0), 0u);  // not measured
}

TEST(ModelWarnings, surfaces_that_meet_and_should_not) {
    for (const auto& [joined_mm, expected] : {std::pair{1.1, 1}, {0.9, 0}}) {
        ModelReport report;
        report.field_distance.points = 10;
        report.field_distance.joined_mm = joined_mm;
        RunContext context;
        warn_of_model(report, 2.0, "drawn.json", context);
        EXPECT_EQ(std::count_if(context.warnings.begin(), context.warnings.end(),
                                [](const Warning& warning) { return warning.code == "W-PIP-009"; }),
                  expected);
    }
}

}  // namespace
}  // namespace anatomesh
