// Laws of slices about an axis, on families of axes and of planes that run through them or beside them.
#include "anatomesh/slices/arrangement/rotational_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "anatomesh/field/rotational_fixtures_for_test.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh::rotational_sweep_test {
namespace {

using namespace fixtures;

std::optional<RotationalSweep> sweep_about_axis(const ContourSet& set, double max_gap = default_max_gap) {
    return RotationalSweep::of(set, rotation_axis(set), max_gap);
}

constexpr double pi = std::numbers::pi;

struct Scan {
    Plane axis;  // the normal of this frame
    ContourSet set;
};

std::vector<Scan> scans() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Scan> made;
    for (const int planes : {2, 3, 4, 7, 12, 18, 45}) {
        const Plane axis = make_plane({10 * unit(random), 10 * unit(random), 10 * unit(random)},
                                      {unit(random), unit(random), 2 + unit(random)});
        const Ellipsoid solid{axis.origin + Vec3{4 * unit(random), 4 * unit(random), 0}, {30, 22, 40}};
        made.push_back({axis, sections_of(solid, in_any_order(planes_about(axis, planes), random), 60)});
    }
    return made;
}

double signed_area(const ContourSet& set, const Contour& contour) {
    const Plane& plane = set.slices[contour.slice].plane;
    Ring ring;
    for (const Vec3& p : set.points_of(contour)) ring.push_back(plane.to_plane(p));
    return area_of(ring);
}

TEST(RotationalSweep, every_half_plane_gets_a_height_of_its_own_and_keeps_its_shape) {
    for (const Scan& scan : scans()) {
        const ContourSet& set = scan.set;
        const auto sweep = sweep_about_axis(set);
        ASSERT_TRUE(sweep);
        const ContourSet straight = sweep->to_chart(set);
        EXPECT_GE(straight.slices.size(), 2 * set.slices.size());
        for (std::size_t s = 0; s < straight.slices.size(); ++s) {
            const double height = straight.slices[s].plane.origin.z;
            if (s > 0) {
                EXPECT_GT(height, straight.slices[s - 1].plane.origin.z);
            }
            for (const Contour& contour : straight.contours_of(straight.slices[s])) {
                EXPECT_EQ(contour.slice, s);
                for (const Vec3& p : straight.points_of(contour)) ASSERT_EQ(p.z, height);
                // One contour a slice: the same area, on the same side.
                const double area = signed_area(straight, contour);
                EXPECT_TRUE(std::any_of(set.contours.begin(), set.contours.end(), [&](const Contour& drawn) {
                    return std::abs(signed_area(set, drawn) - area) < 1e-9 * area;
                }));
            }
        }
    }
}

TEST(RotationalSweep, points_of_contours_come_where_their_contours_are) {
    for (const Scan& scan : scans()) {
        const ContourSet& set = scan.set;
        const auto sweep = sweep_about_axis(set);
        ASSERT_TRUE(sweep);
        const ContourSet straight = sweep->to_chart(set);
        for (const Vec3& p : set.points) {
            const Vec3 q = sweep->to_chart(p);
            EXPECT_GE(q.x, 0);
            ASSERT_EQ(std::count(straight.points.begin(), straight.points.end(), q), 1);
        }
    }
}

TEST(RotationalSweep, chart_coordinates_are_cylindrical_about_one_axis) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const Scan& scan : scans()) {
        const ContourSet& set = scan.set;
        const Plane& axis = scan.axis;
        const auto sweep = sweep_about_axis(set);
        ASSERT_TRUE(sweep);
        EXPECT_NEAR(sweep->angle(axis.origin + axis.u + 0.3 * axis.v),
                    pi / static_cast<double>(set.slices.size()), 1e-9);
        const double along =
            sweep->to_chart(axis.origin + axis.normal + axis.u).y - sweep->to_chart(axis.origin + axis.u).y;
        EXPECT_NEAR(std::abs(along), 1, 1e-9);
        for (int trial = 0; trial < 50; ++trial) {
            const double radius = 20 + 19 * unit(random), start = pi * unit(random), z = 30 * unit(random);
            EXPECT_EQ(sweep->apart_from(axis.origin + radius * axis.u), 0);
            const auto at = [&](double angle) {
                return sweep->to_chart(axis.origin + z * axis.normal + radius * std::cos(angle) * axis.u +
                                       radius * std::sin(angle) * axis.v);
            };
            const double y = at(start).y;
            int back = 0;  // where the turn begins again
            for (int step = 0; step < 72; ++step) {
                const Vec3 from = at(start + step * pi / 36), to = at(start + (step + 1) * pi / 36);
                EXPECT_NEAR(from.x, radius, 1e-9);
                EXPECT_NEAR(from.y, y, 1e-9);
                EXPECT_NE(from.z, to.z);
                back += (to.z < from.z) == (along > 0);
            }
            EXPECT_TRUE(back == 1 || back == 71) << back;
        }
    }
}

TEST(RotationalSweep, slices_that_do_not_follow_each_other_all_round_are_none) {
    const Plane axis = make_plane({1, 2, 3}, {0.2, -0.1, 1});
    const Ellipsoid solid{{}, {30, 22, 40}};
    const auto is_sweep = [&](const std::vector<Plane>& planes) {
        return sweep_about_axis(sections_of(solid, planes, 60)).has_value();
    };
    const std::vector<Plane> all = planes_about(axis, 12);
    EXPECT_TRUE(is_sweep(all));
    EXPECT_TRUE(is_sweep({all[0], all[6]}));
    EXPECT_TRUE(is_sweep({all[0], all[5]}));
    EXPECT_FALSE(is_sweep({all[0], all[1]}));  // most is between them
    EXPECT_FALSE(is_sweep({all[0]}));
    std::vector<Plane> some = all;
    some.erase(some.begin() + 4);
    EXPECT_TRUE(is_sweep(some));  // one missing
    some.erase(some.begin() + 4);
    EXPECT_TRUE(is_sweep(some));                            // two beside each other
    EXPECT_TRUE(is_sweep({all.begin(), all.begin() + 7}));  // open on both sides
    std::vector<Plane> stacks;
    for (double h = -15; h <= 15; h += 5) {
        stacks.push_back(make_plane({0, 0, h}, {0, 0, 1}));
        EXPECT_EQ(is_sweep(stacks), false);
    }
    for (double h = -15; h <= 15; h += 5) stacks.push_back(make_plane({h, 0, 0}, {1, 0, 0}));
    EXPECT_FALSE(is_sweep(stacks));
    std::vector<Plane> across = all;
    across.push_back(make_plane(axis.origin, axis.normal));
    EXPECT_FALSE(is_sweep(across));
    std::mt19937 random(8);
    EXPECT_FALSE(is_sweep(beside_their_places(all, 12, 0, random)));
    EXPECT_FALSE(is_sweep(beside_their_places(all, 0, 0.6, random)));
}

// The widest gap, in degrees, and whether what is drawn goes on over it.
std::pair<double, bool> widest_gap(const ContourSet& set, double max_gap) {
    const auto sweep = sweep_about_axis(set, max_gap);
    EXPECT_TRUE(sweep);
    std::pair<double, bool> widest{0, true};
    for (const RotationalSweep::Gap& gap : sweep->wide_gaps())
        widest = std::max(widest, {gap.angle * 180 / pi, gap.joined},
                          [](const auto& a, const auto& b) { return a.first < b.first - 1e-6; });
    return widest;
}

TEST(RotationalSweep, wide_gaps_are_joined_where_most_that_is_drawn_is_round_the_axis_or_it_is_asked_for) {
    const Plane axis = make_plane({1, 2, 3}, {0.2, -0.1, 1});
    const std::vector<Plane> all = planes_about(axis, 18);
    const auto set_of = [&](std::size_t count, bool round_axis) {
        const std::vector<Plane> planes{all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)};
        if (round_axis) return sections_of({axis.origin, {30, 22, 40}}, planes, 60);
        SetBuilder builder;
        for (const Plane& plane : planes) {
            builder.slice(plane);
            const Vec2 out = plane.to_plane(axis.origin + cross(plane.normal, axis.normal));
            for (const double side : {-20.0, 20.0}) builder.ring(0, circle(side * out, 6, 40));
        }
        return builder.set;
    };
    struct Case {
        std::size_t planes;
        bool round_axis;
        double max_gap;
        bool joined;
    };
    for (const Case& c : {Case{16, true, 2, true}, Case{16, false, 2, true}, Case{13, true, 2, true},
                          Case{13, false, 2, false}, Case{13, false, 5, true}, Case{10, true, 2, false},
                          Case{10, true, 8, true}, Case{6, true, 18, false}, Case{4, true, 2, false}}) {
        const auto [angle, joined] = widest_gap(set_of(c.planes, c.round_axis), c.max_gap);
        EXPECT_NEAR(angle, 10.0 * static_cast<double>(19 - c.planes), 1e-6);
        EXPECT_EQ(joined, c.joined) << c.planes << " " << c.round_axis << " " << c.max_gap;
    }
}

TEST(RotationalSweep, what_is_on_both_sides_of_an_open_gap_is_far_apart) {
    const Plane axis = make_plane({}, {0, 0, 1});
    const std::vector<Plane> all = planes_about(axis, 18);
    const ContourSet set = sections_of({{}, {30, 22, 40}}, {all.begin(), all.begin() + 9}, 60);
    const auto sweep = sweep_about_axis(set);
    ASSERT_TRUE(sweep);
    // From slice to slice and over both gaps: by as much as the angle, but in the middle of the gaps.
    const auto at = [&](double degrees) {
        const double a = degrees * pi / 180;
        return sweep->to_chart(20 * std::cos(a) * axis.u + 20 * std::sin(a) * axis.v);
    };
    const double degree = std::abs(at(31).z - at(30).z);
    int jumps = 0;
    for (int a = 0; a < 360; ++a) {
        const Vec3 from = at(a + 0.5), to = at(a + 1.5);
        EXPECT_NEAR(from.x, 20, 1e-9);
        if (std::abs(to.z - from.z) > 1e5)
            ++jumps;
        else
            EXPECT_NEAR(std::abs(to.z - from.z), degree, 0.02 * degree) << a;
    }
    EXPECT_EQ(jumps, 2 + 1);  // and where the turn begins
}

TEST(RotationalSweep, slices_on_one_side_of_the_axis_are_open_behind_it) {
    // A fan whose apex is near.
    const Plane axis = make_plane({}, {0, 0, 1});
    const Vec3 out = axis.u;
    std::vector<Plane> planes;
    for (int k = -5; k <= 5; ++k) {
        const double a = k * pi / 24;
        planes.push_back(make_plane({}, std::cos(a) * axis.v - std::sin(a) * axis.u));
    }
    const auto sweep = sweep_about_axis(sections_of({24.0 * out, {22, 22, 22}}, planes, 60));
    ASSERT_TRUE(sweep);
    EXPECT_TRUE(sweep->wide_gaps().empty()) << "nothing is missing behind it";
    // Rising from the middle of what is behind all round to it, but where the turn begins, or falling.
    const auto at = [&](int degrees) {
        const double a = degrees * pi / 180;
        return sweep->to_chart(20 * std::cos(a) * axis.u + 20 * std::sin(a) * axis.v);
    };
    int jumps = 0, rising = 0, steps = 0;
    for (int a = -178; a < 178; a += 2) {
        const Vec3 from = at(a), to = at(a + 2);
        EXPECT_NEAR(to.x, 20, 1e-9);
        ++steps;
        if (std::abs(to.z - from.z) > 2)
            ++jumps;
        else
            rising += to.z > from.z;
    }
    EXPECT_LE(jumps, 1);
    EXPECT_TRUE(rising == 0 || rising == steps - jumps) << rising;
}

TEST(RotationalSweep, two_slices_on_one_side_of_the_axis_are_as_far_apart_as_they_are) {
    const Plane axis = make_plane({}, {0, 0, 1});
    const std::vector<Plane> planes{plane_about(axis, 0.1), plane_about(axis, 0.4)};
    const auto sweep = sweep_about_axis(sections_of({25.0 * axis.u, {22, 22, 22}}, planes, 60));
    ASSERT_TRUE(sweep);
    EXPECT_NEAR(sweep->angle(std::cos(0.2) * axis.u + std::sin(0.2) * axis.v), 0.3, 1e-9);
    EXPECT_TRUE(sweep->wide_gaps().empty());
}

TEST(RotationalSweep, half_planes_on_which_next_to_nothing_is_drawn_leave_it_open) {
    const Plane axis = make_plane({}, {0, 0, 1});
    // How far the axis lies inside an outline of 20 mm round.
    const auto is_sweep = [&](double inside) {
        const Ellipsoid solid{{20 - inside, 0, 0}, {20, 20, 20}};
        return sweep_about_axis(sections_of(solid, planes_about(axis, 12), 90)).has_value();
    };
    EXPECT_TRUE(is_sweep(20));
    EXPECT_TRUE(is_sweep(12));
    EXPECT_FALSE(is_sweep(2));
    EXPECT_TRUE(is_sweep(-2)) << "on one side of the axis alone";
}

TEST(RotationalSweep, planes_that_run_beside_the_axis_are_one_from_where_they_are_apart) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Plane axis = make_plane({1, 2, 3}, {0.2, -0.1, 1});
    for (const int planes : {4, 8, 12, 20}) {
        const double beside = 1.0 / planes;
        const ContourSet set =
            sections_of({{}, {30, 22, 40}},
                        beside_their_places(in_any_order(planes_about(axis, planes), random), beside,
                                            beside / 40, random),
                        90);
        const auto sweep = sweep_about_axis(set);
        ASSERT_TRUE(sweep) << planes;
        const ContourSet straight = sweep->to_chart(set);
        for (const Contour& contour : set.contours) {
            const Plane& plane = set.slices[contour.slice].plane;
            for (const Vec3& p : set.points_of(contour)) {
                if (sweep->radius(p) < sweep->apart_from(p)) continue;
                const Vec3 q = sweep->to_chart(p);
                ASSERT_EQ(std::count(straight.points.begin(), straight.points.end(), q), 1);
                // The same from both sides, but where the turn begins.
                const Vec3 before = sweep->to_chart(p - 1e-7 * plane.normal),
                           after = sweep->to_chart(p + 1e-7 * plane.normal);
                if (std::abs(before.z - after.z) > 1) continue;
                EXPECT_LT(length(before - q), 1e-5);
                EXPECT_LT(length(after - q), 1e-5);
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::rotational_sweep_test
