// Laws of slices along paths, on families of tubes.
#include "anatomesh/slices/arrangement/paths_of_slices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/drawn_tubes_for_test.h"
#include "anatomesh/field/rotational_fixtures_for_test.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh::paths_of_slices_test {
namespace {

using namespace fixtures;

const auto radius_6 = [](double) { return 6.0; };

// How many contours lie on paths.
std::size_t contours_on(const std::vector<SlicePath>& paths) {
    std::size_t count = 0;
    for (const SlicePath& path : paths) {
        for (const PathSlice& slice : path.slices()) count += slice.contours.size();
    }
    return count;
}

TEST(PathsOfSlices, a_tube_is_one_path_in_the_order_in_which_it_is_drawn) {
    for (const auto& [name, tube] : families_of_tubes()) {
        const ContourSet set = drawn({tube});
        const auto paths = paths_of_slices(set);
        ASSERT_TRUE(paths && paths->size() == 1) << name;
        const auto slices = paths->front().slices();
        ASSERT_EQ(slices.size(), set.slices.size()) << name;
        const bool forwards = slices.front().slice == 0;
        for (std::uint32_t n = 0; n < slices.size(); ++n)
            EXPECT_EQ(slices[forwards ? n : slices.size() - 1 - n].slice, n) << name;
        // A bend without legs may be one about an axis, and slices that lean by little a sweep.
        EXPECT_NE(arrangement_of(set).kind, ArrangementKind::general) << name;
    }
}

TEST(PathsOfSlices, contours_get_the_height_of_their_slice_and_keep_their_shape) {
    for (const auto& [name, tube] : families_of_tubes()) {
        const ContourSet set = drawn({tube});
        const SlicePath path = paths_of_slices(set)->front();
        const ContourSet straight = path.to_chart(set);
        ASSERT_EQ(straight.contours.size(), set.contours.size());
        for (std::uint32_t n = 0; n < straight.slices.size(); ++n) {
            if (n > 0) {
                EXPECT_GT(path.height(n), path.height(n - 1));
            }
            for (const Contour& contour : straight.contours_of(straight.slices[n])) {
                Ring ring;
                for (const Vec3& p : straight.points_of(contour)) {
                    ASSERT_EQ(p.z, path.height(n));
                    ring.push_back({p.x, p.y});
                }
                const double radius =
                    length(set.points_of(set.contours[path.slices()[n].contours.front()]).front() -
                           set.slices[path.slices()[n].slice].plane.origin);
                EXPECT_NEAR(area_of(ring), area_of(circle({}, radius, corners_of_tube)),
                            1e-9 * radius * radius)
                    << name;
            }
        }
    }
}

// On a slice the gaps on both sides say the same; between two slices the distance from the path stays.
TEST(PathsOfSlices, charts_are_continuous_and_keep_the_distance_from_the_path) {
    const Tube tube{arch_path(30, 50, 25), radius_6, 5};
    const ContourSet set = drawn({tube});
    const SlicePath path = paths_of_slices(set)->front();
    const auto middle = path.to_chart(1, tube.path.at(5).at);
    ASSERT_TRUE(middle);
    for (double s = 4; s + 4 < tube.path.length; s += 0.7) {
        const PathPoint at = tube.path.at(s);
        for (const Vec3 off : {Vec3{0, 5, 0}, 5.0 * cross(at.along, Vec3{0, 1, 0})}) {
            std::size_t gaps = 0;
            for (std::size_t gap = 0; gap < path.gap_count(); ++gap) {
                const auto q = path.to_chart(gap, at.at + off);
                if (!q || std::hypot(q->x - middle->x, q->y - middle->y) > 20) continue;
                ++gaps;
                // The path between two slices is an arc, or straight where they are parallel: 0.2 mm apart at most.
                EXPECT_NEAR(std::hypot(q->x - middle->x, q->y - middle->y), 5, 0.2);
            }
            EXPECT_GE(gaps, 1u);
        }
    }
}

TEST(PathsOfSlices, legs_on_one_plane_are_two_parts_of_one_path) {
    for (const double spacing : {2.0, 4.0, 6.0}) {
        // Both legs are drawn on the planes z = 2, 6, 10 ..., as files without planes have them.
        const Tube tube{arch_path(60, 60, 30), [](double) { return 12.0; }, spacing};
        const ContourSet apart = drawn({tube});
        SetBuilder builder;
        std::vector<std::uint8_t> taken(apart.slices.size(), 0);
        for (std::uint32_t i = 0; i < apart.slices.size(); ++i) {
            if (taken[i]) continue;
            const Plane& plane = apart.slices[i].plane;
            builder.slice(plane);
            for (std::uint32_t j = i; j < apart.slices.size(); ++j) {
                const Plane& other = apart.slices[j].plane;
                const bool same = std::abs(plane.signed_distance(other.origin)) < 1e-9 &&
                                  length(cross(plane.normal, other.normal)) < 1e-9;
                if (!same) continue;
                taken[j] = 1;
                Ring ring;
                for (const Vec3& p : apart.points_of(apart.contours[j])) ring.push_back(plane.to_plane(p));
                builder.ring(0, area_of(ring) > 0 ? ring : reversed(ring));
            }
        }
        ASSERT_LT(builder.set.slices.size(), apart.slices.size());
        const auto paths = paths_of_slices(builder.set);
        ASSERT_TRUE(paths && paths->size() == 1) << spacing;
        EXPECT_EQ(paths->front().slices().size(), apart.slices.size());
        EXPECT_EQ(contours_on(*paths), builder.set.contours.size());
    }
}

TEST(PathsOfSlices, a_branch_is_a_path_of_its_own_also_where_it_begins_in_its_parent) {
    for (const double tilt : {0.0, 0.3, 0.6}) {
        for (const std::uint32_t structure : {0u, 1u}) {
            const Tube trunk{arch_path(60, 100, 30), [](double) { return 12.0; }, 4};
            const Tube branch{
                straight_path({0, 0, 90}, Vec3{40 * std::sin(tilt), 0, 90 + 40 * std::cos(tilt)}),
                [](double) { return 5.0; }, 3, structure};
            const ContourSet set = drawn({trunk, branch});
            const auto paths = paths_of_slices(set);
            ASSERT_TRUE(paths) << tilt;
            EXPECT_EQ(paths->size(), 2u) << tilt;
            EXPECT_EQ(contours_on(*paths), set.contours.size());
        }
    }
}

TEST(PathsOfSlices, planes_that_cross_in_what_they_draw_are_no_paths) {
    const Ellipsoid solid{{0, 0, 0}, {30, 22, 40}};
    std::vector<Plane> planes;
    for (double h = -15; h < 16; h += 5) {
        planes.push_back(make_plane({0, 0, h}, {0, 0, 1}));
        planes.push_back(make_plane({h, 0, 0}, {1, 0, 0}));
    }
    EXPECT_FALSE(paths_of_slices(sections_of(solid, planes, 60)));
    // All of a short tube lies in another one.
    const Tube trunk{straight_path({0, 0, 0}, {0, 0, 60}), [](double) { return 14.0; }, 4};
    const Tube inner{straight_path({-10, 0, 30}, {10, 0, 30}), [](double) { return 4.0; }, 3};
    EXPECT_FALSE(paths_of_slices(drawn({trunk, inner})));
    EXPECT_TRUE(paths_of_slices(drawn({trunk, {inner.path, inner.radius, 3, 1}})));
    // A ring has no end.
    const Path ring{[](double s) {
                        return PathPoint{{30 * std::cos(s / 30), 30 * std::sin(s / 30), 0},
                                         {-std::sin(s / 30), std::cos(s / 30), 0}};
                    },
                    60 * std::numbers::pi};
    EXPECT_FALSE(paths_of_slices(drawn({{ring, radius_6, 8}})));
}

// A hand turns the probe by some degrees: now and then two slices cross in the body, and chains of the others are no
// branches.
TEST(PathsOfSlices, a_probe_by_hand_whose_slices_cross_here_and_there_has_none) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-0.5, 0.5);
    std::size_t crossing = 0;
    for (int n = 0; n < 60; ++n) {
        const Ellipsoid solid{{0, 0, 0}, {24, 18, 28}};
        const double lean = 0.1 + 0.4 * (unit(random) + 0.5), spacing = 2 + 2 * (unit(random) + 0.5);
        std::vector<Plane> planes;
        for (double at = -22; at < 23; at += spacing * (1 + 0.8 * unit(random)))
            planes.push_back(make_plane({0, 0, at}, {lean * unit(random), lean * unit(random), 1}));
        const ContourSet set = sections_of(solid, planes, 60);
        const auto paths = paths_of_slices(set);
        crossing += !paths;
        if (paths) {
            EXPECT_EQ(paths->size(), 1u) << n;
        }
    }
    EXPECT_GT(crossing, 20u);
    EXPECT_LT(crossing, 55u);
}

// Some of their planes cross: few are skipped, and none where they do not.
TEST(PathsOfSlices, a_tube_on_planes_that_were_set_by_eye_is_one_path) {
    std::size_t skipping = 0, n = 0;
    for (const auto& [name, tube] : random_tubes(160, 11)) {
        ++n;
        if (name == "straight") continue;
        for (const double turned : {0.0, 3.0, 6.0}) {
            const ContourSet set = drawn_by_eye(tube, turned / 6, turned, static_cast<unsigned>(n));
            const auto paths = paths_of_slices(set);
            ASSERT_TRUE(paths && paths->size() == 1) << name << " " << n << " " << turned;
            const std::size_t skipped = set.contours.size() - contours_on(*paths);
            EXPECT_LE(4 * skipped, set.slices.size()) << name << " " << n;
            if (turned == 0) {
                EXPECT_EQ(skipped, 0u) << name << " " << n;
            }
            skipping += skipped > 0;
            // What is left has the same path.
            std::vector<std::uint32_t> rest;
            for (const PathSlice& slice : paths->front().slices()) rest.push_back(slice.slice);
            std::sort(rest.begin(), rest.end());
            EXPECT_EQ(contours_on(*paths_of_slices(chosen_slices(set, rest))), rest.size())
                << name << " " << n;
        }
    }
    EXPECT_GT(skipping, 20u);
}

// Also tubes of one radius, which agree where their middles cross.
TEST(PathsOfSlices, branches_may_be_as_thick_as_their_parent) {
    for (const double degrees : {30.0, 45.0, 70.0, 90.0}) {
        for (const double radius : {6.0, 10.0}) {
            const double a = degrees * std::numbers::pi / 180;
            const auto radius_of = [=](double) { return radius; };
            const Tube trunk{straight_path({0, 0, 0}, {0, 0, 120}), radius_of, 3};
            const Tube branch{
                straight_path({0, 0, 60}, Vec3{0, 0, 60} + 80.0 * Vec3{std::sin(a), 0, std::cos(a)}),
                radius_of, 3};
            const auto paths = paths_of_slices(drawn({trunk, branch}));
            ASSERT_TRUE(paths) << degrees << " " << radius;
            EXPECT_EQ(paths->size(), 2u);
        }
    }
}

// The legs of a Y mirror each other, and their slices agree in the mirror.
TEST(PathsOfSlices, legs_of_a_fork_that_are_alike_are_paths) {
    for (const double degrees : {30.0, 60.0, 90.0, 120.0}) {
        for (const double spacing : {3.0, 6.0, 8.0}) {
            const double a = 0.5 * degrees * std::numbers::pi / 180;
            const Tube trunk{straight_path({0, 0, 0}, {0, 0, 60}), [](double) { return 12.0; }, spacing};
            std::vector<Tube> tubes{trunk};
            for (const double side : {-1.0, 1.0}) {
                const Vec3 along{side * std::sin(a), 0, std::cos(a)};
                tubes.push_back({straight_path({0, 0, 60}, Vec3{0, 0, 60} + 60.0 * along),
                                 [](double) { return 8.0; }, spacing});
            }
            const auto paths = paths_of_slices(drawn(tubes));
            ASSERT_TRUE(paths) << degrees << " " << spacing;
            // A trunk whose last slice does not cut a leg goes on into it.
            EXPECT_GE(paths->size(), 2u) << degrees << " " << spacing;
        }
    }
}

TEST(PathsOfSlices, structures_that_exclude_each_other_have_none) {
    ContourSet set = drawn({{arch_path(30, 50, 25), radius_6, 5}});
    set.structures.push_back({2, "other", {200, 200, 200}});
    EXPECT_TRUE(paths_of_slices(set));
    set.exclusive = true;
    EXPECT_FALSE(paths_of_slices(set));
}

}  // namespace
}  // namespace anatomesh::paths_of_slices_test
