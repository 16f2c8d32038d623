// Laws of the motion between two slices.
#include "anatomesh/field/motion/slice_motion.h"

#include <gtest/gtest.h>

#include "anatomesh/field/field_fixtures.h"

namespace anatomesh::slice_motion_test {
namespace {

using namespace fixtures;

bool overlap(const Ring& below, const Ring& above) {
    const DistanceMap lower(edges_of({below}), 4.5), upper(edges_of({above}), 4.5);
    return SliceMotion(lower, upper, 3, {}, {}).overlaps();
}

// A circle turned a little: no vertex of either lies within the other.
TEST(SliceMotion, circles_of_any_number_of_points_overlap_however_turned) {
    int circles = 0;
    for (int points = 3; points < 160; points += 7) {
        for (const double turn : {0.0, 0.1, 0.37, 0.5, 0.9}) {
            const double phase = turn * 2 * std::numbers::pi / points;
            EXPECT_TRUE(overlap(circle({}, 40, points), circle({}, 40, points, phase)))
                << points << " " << turn;
            EXPECT_FALSE(overlap(circle({}, 40, points), circle({81, 0}, 40, points, phase)));
            ++circles;
        }
    }
    EXPECT_GT(circles, 100);
}

}  // namespace
}  // namespace anatomesh::slice_motion_test
