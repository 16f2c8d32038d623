#include "anatomesh/live/draw/copy_rings.h"

#include <gtest/gtest.h>

#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::copy_rings_test {
namespace {

using namespace draw_fixtures;

TEST(CopyRings, to_a_parallel_plane_moves_each_point_by_the_step_between_the_planes) {
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        const StructureRings before = random_rings(random, plane);
        Plane next = plane;
        next.origin = next.origin + uniform(random, -20, 20) * plane.normal;
        const StructureRings copy = copy_rings(before, next).value();
        expect_sound(copy);
        ASSERT_EQ(copy.rings.size(), before.rings.size());
        for (std::size_t r = 0; r < copy.rings.size(); ++r) {
            ASSERT_EQ(copy.rings[r].size(), before.rings[r].size());
            for (std::size_t i = 0; i < copy.rings[r].size(); ++i) {
                const Vec3 step =
                    (copy.rings[r].points[i] - next.origin) - (before.rings[r].points[i] - plane.origin);
                EXPECT_LT(length(step), 1e-6);
            }
        }
    }
}

TEST(CopyRings, to_a_turned_plane_turns_the_picture) {
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const StructureRings before = random_rings(random, random_plane(random));
        const Plane other = random_plane(random);
        const StructureRings copy = copy_rings(before, other).value();
        for (std::size_t r = 0; r < copy.rings.size(); ++r) {
            for (std::size_t i = 0; i < copy.rings[r].size(); ++i) {
                EXPECT_LT(length(copy.rings[r].at[i] - before.rings[r].at[i]), 1e-6);
                EXPECT_LT(std::abs(other.signed_distance(copy.rings[r].points[i])), 1e-6);
            }
        }
        EXPECT_NEAR(area_of(copy), area_of(before), 1e-6);
    }
}

TEST(CopyRings, refuses_a_bad_plane) {
    Plane bad;
    bad.u = {2, 0, 0};
    EXPECT_EQ(copy_rings({}, bad).error().code, "E-LIV-006");
    bad.u.x = NAN;
    EXPECT_EQ(copy_rings({}, bad).error().code, "E-LIV-001");
}

}  // namespace
}  // namespace anatomesh::copy_rings_test
