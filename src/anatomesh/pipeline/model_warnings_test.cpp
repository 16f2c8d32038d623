#include "anatomesh/pipeline/model_warnings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
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

TEST(ModelWarnings, a_part_that_is_missing_and_one_too_many) {
    for (const bool missing : {true, false}) {
        for (const auto& [max_mm, points, expected] :
             {std::tuple{1.1, 10, true}, {0.9, 10, false}, {1.1, 0, false}}) {
            ModelReport report;
            report.field_difference.points = static_cast<std::uint64_t>(points);
            report.field_difference.max_mm = max_mm;
            report.field_difference.missing = missing;
            RunContext context;
            warn_of_model(report, 2.0, "drawn.json", context);
            ASSERT_EQ(context.warnings.size(), expected ? 1u : 0u);
            if (!expected) continue;
            EXPECT_EQ(context.warnings[0].code, "W-PIP-010");
            EXPECT_EQ(context.warnings[0].message.find("is missing in the model") != std::string::npos,
                      missing);
        }
    }
}

}  // namespace
}  // namespace anatomesh
