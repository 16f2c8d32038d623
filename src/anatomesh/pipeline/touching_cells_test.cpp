// Where structures touch each other, points put beside contour segments leave no cells that clause 4 forbids.
#include <gtest/gtest.h>

#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::touching_cells_test {
namespace {

using namespace fixtures;

// Two blocks that touch along a line; a notch and a knob on it step sideways from slice to slice.
Drawing touching_blocks(double step, double depth, double spacing) {
    Drawing drawing;
    for (int n = 0; n < 8; ++n) {
        const double z = n * spacing, s = (n % 3 - 1) * step, d = n % 2 ? depth : 0;
        const Polygon lower{{-9, -9}, {9, -9}, {9, 0}, {s + 2, 0}, {s, -d}, {s - 2, 0}, {-9, 0}};
        const Polygon upper{{9, 9}, {-9, 9}, {-9, d}, {s - 3, d}, {s, 0}, {s + 3, d}, {9, d}};
        drawing.add(0, z, divided(lower, 2));
        drawing.add(1, z, divided(upper, 2));
    }
    return drawing;
}

// Cells at points put beside segments after all other refinement are refined too: 475 above ratio 2, 581 without.
TEST(TouchingCells, clause_4_is_kept_with_few_cells_above_ratio_2) {
    std::uint64_t above = 0, cells = 0;
    for (const double step : {0.5, 1.0, 2.0, 3.0}) {
        for (const double depth : {0.4, 1.0, 2.5}) {
            for (const double spacing : {1.5, 3.0}) {
                SCOPED_TRACE("step " + std::to_string(step) + ", depth " + std::to_string(depth) +
                             ", slices " + std::to_string(spacing) + " apart");
                const auto made = build(kept(touching_blocks(step, depth, spacing).raw));
                ASSERT_TRUE(made.ok()) << to_line(made.error());
                const ModelReport& report = made.value().report;
                const Clause& clause = report.certificate.at(3);
                EXPECT_EQ(clause.state, ClauseState::kept) << clause.evidence;
                above += report.quality.radius_edge.over_2;
                cells += report.counts.tetrahedra;
            }
        }
    }
    EXPECT_LT(above, 520u) << "of " << cells;
}

}  // namespace
}  // namespace anatomesh::touching_cells_test
