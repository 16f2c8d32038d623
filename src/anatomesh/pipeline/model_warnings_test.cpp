#include "anatomesh/pipeline/model_warnings.h"

#include <gtest/gtest.h>

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
    EXPECT_EQ(warnings_of_distance(2.1, false), 1u);
    EXPECT_EQ(warnings_of_distance(1.9, false), 0u);
    // The field tells no more than this: it may be any distance.
    EXPECT_EQ(warnings_of_distance(1.5, true), 1u);
    EXPECT_EQ(warnings_of_distance(3, true, 0), 0u);  // not measured
}

}  // namespace
}  // namespace anatomesh
