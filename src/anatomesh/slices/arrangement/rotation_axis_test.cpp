// The axis is found, whether planes run through it or beside it.
#include "anatomesh/slices/arrangement/rotation_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/field/rotational_fixtures_for_test.h"

namespace anatomesh::rotation_axis_test {
namespace {

using namespace fixtures;

double off(const Axis& axis, Vec3 p) {
    return length(cross(p - axis.origin, axis.direction));
}

TEST(RotationAxis, is_the_line_that_planes_run_through_or_beside_which_they_all_run) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const int planes : {2, 3, 5, 8, 12, 25}) {
        for (const double beside : {0.0, 0.3, 2.0, 5.0}) {
            if (beside > 0 && planes < 8) continue;  // these may be anywhere
            const Plane axis = make_plane({10 * unit(random), 5 * unit(random), 8 * unit(random)},
                                          {unit(random), unit(random), 2});
            std::vector<Plane> cut = planes_about(axis, planes);
            // The turn began somewhere: those before that are on the other side.
            const int begun = planes * 2 / 5;
            for (int k = 0; k < planes; ++k)
                cut[static_cast<std::size_t>(k)].origin +=
                    (k < begun ? -beside : beside) * cut[static_cast<std::size_t>(k)].normal;
            const ContourSet set =
                sections_of({axis.origin, {30, 22, 40}}, in_any_order(std::move(cut), random), 60);
            const Axis found = rotation_axis(set);
            EXPECT_NEAR(std::abs(dot(found.direction, axis.normal)), 1, 1e-9);
            EXPECT_LT(off(found, axis.origin), 1e-6) << planes << " " << beside;
            EXPECT_NEAR(found.beside, beside, 1e-6);
        }
    }
}

TEST(RotationAxis, of_planes_that_all_lean_against_it_is_the_one_they_were_turned_about) {
    std::mt19937 random(7);
    for (const int planes : {8, 12, 24}) {
        for (const double lean : {0.05, 0.2}) {
            const Plane axis = make_plane({1, 2, 3}, {0.2, -0.1, 1});
            std::vector<Plane> cut = planes_about(axis, planes);
            for (Plane& plane : cut) plane = make_plane(axis.origin, plane.normal + lean * axis.normal);
            const ContourSet set =
                sections_of({axis.origin, {30, 22, 40}}, in_any_order(std::move(cut), random), 60);
            const Axis found = rotation_axis(set);
            EXPECT_NEAR(std::abs(dot(found.direction, axis.normal)), 1, 1e-9) << planes << " " << lean;
            EXPECT_LT(off(found, axis.origin), 1e-6);
            EXPECT_NEAR(found.beside, 40 * lean, 8 * lean);
        }
    }
}

TEST(RotationAxis, of_planes_here_and_there_is_nearest_to_them) {
    std::mt19937 random(4);
    const Plane axis = make_plane({1, 2, 3}, {0.2, -0.1, 1});
    for (const int planes : {3, 5, 8, 12, 25}) {
        for (const double beside : {0.2, 1.0}) {
            const ContourSet set = sections_of(
                {axis.origin, {30, 22, 40}},
                beside_their_places(in_any_order(planes_about(axis, planes), random), beside, 0, random), 60);
            EXPECT_LT(off(rotation_axis(set), axis.origin), beside) << planes;
        }
    }
}

}  // namespace
}  // namespace anatomesh::rotation_axis_test
