// Laws of outlines of several structures that cross at small angles, or run a hair's breadth apart.
#include <gtest/gtest.h>

#include <cmath>

#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh {
namespace {

using namespace fixtures;

constexpr int slices = 4;

// Two outlines of the same lobed shape with vertices about 1 mm apart; the second is turned and moved by a
// little, so that the two cross where that takes them.
Drawing crossing(double degrees, double shift) {
    Drawing drawing;
    const auto outline = [](double turned, Vec2 centre, int corners) {
        Polygon polygon;
        for (int k = 0; k < corners; ++k) {
            const double turn = 2 * pi * k / corners, r = 8 + 1.5 * std::cos(3 * turn + 0.4),
                         at = turn + turned;
            polygon.push_back({centre.x + r * std::cos(at), centre.y + r * std::sin(at)});
        }
        return polygon;
    };
    for (int n = 0; n < slices; ++n) {
        drawing.add(0, 2.5 * n, outline(0.05 * n, {0, 0}, 50));
        drawing.add(1, 2.5 * n, outline(0.05 * n + degrees * pi / 180, {shift, 0.3 * shift}, 47));
    }
    return drawing;
}

// A quarter of the segments was missed before pieces followed the distance of the other outline.
TEST(CrossingOutlines, keep_nearly_all_of_their_segments) {
    std::size_t missed = 0, segments = 0;
    for (const double degrees : {1.0, 3.0, 6.0, 20.0}) {
        for (const double shift : {0.1, 0.4}) {
            SCOPED_TRACE(testing::Message() << "turned " << degrees << " degrees, moved " << shift << " mm");
            const auto made = build(kept(crossing(degrees, shift).raw));
            ASSERT_TRUE(made.ok()) << to_line(made.error());
            const ModelReport& report = made.value().report;
            for (const StructureReport& structure : report.structures) {
                missed += structure.contour_segments - structure.contour_segments_on_surface;
                segments += structure.contour_segments;
            }
            // A few near crossings; all cells that are listed have a ratio that can be lived with.
            std::size_t unforced = 0;
            for (const ListedCell& cell : report.listed_cells) {
                unforced += cell.forced_by.empty() && (cell.value > 4 || cell.min_dihedral_deg < 10);
            }
            EXPECT_LE(unforced, 8u);
        }
    }
    EXPECT_LE(missed, segments / 30);
}

}  // namespace
}  // namespace anatomesh
