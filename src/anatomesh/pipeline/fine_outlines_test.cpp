// Laws of outlines whose vertices lie many times closer than the slices.
#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh {
namespace {

using namespace fixtures;

// A lobed outline that shrinks and turns from slice to slice, 5 mm apart, with vertices `spacing` mm apart.
Drawing lobed(double spacing, double radius, int lobes) {
    Drawing drawing;
    for (int n = 0; n < 4; ++n) {
        const double mean = radius * (1 - 0.08 * n);
        const int corners = static_cast<int>(2 * pi * mean / spacing);
        Polygon outline;
        for (int k = 0; k < corners; ++k) {
            const double turn = 2 * pi * k / corners,
                         r = mean * (1 + 0.15 * std::cos(lobes * turn + 0.2 * n));
            outline.push_back({r * std::cos(turn), r * std::sin(turn)});
        }
        drawing.add(0, 5 * n, outline);
    }
    return drawing;
}

// Between vertices 0.14 mm apart and slices 5 mm apart cells grow all the way: the mean was above 1.
TEST(FineOutlines, have_cells_as_good_in_the_mean_as_others) {
    for (const double spacing : {0.14, 0.3, 0.7}) {
        for (const double radius : {4.0, 8.0}) {
            for (const int lobes : {0, 3}) {
                SCOPED_TRACE(testing::Message() << "vertices " << spacing << " mm apart, radius " << radius
                                                << ", lobes " << lobes);
                const auto made = build(kept(lobed(spacing, radius, lobes).raw));
                ASSERT_TRUE(made.ok()) << to_line(made.error());
                const ModelReport& report = made.value().report;
                const Clause& clause = report.certificate.at(3);
                EXPECT_EQ(clause.state, ClauseState::kept) << clause.evidence;
                EXPECT_LE(report.quality.radius_edge_mean, 0.95) << report.tetrahedra;
                EXPECT_EQ(report.structures.at(0).contour_segments,
                          report.structures.at(0).contour_segments_on_surface);
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh
