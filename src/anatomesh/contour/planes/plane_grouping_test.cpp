// Laws of the grouping of contours into slices, on families of slices whose planes are not declared.
#include "anatomesh/contour/planes/plane_grouping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace anatomesh::plane_grouping_test {
namespace {

using Points = std::vector<Vec3>;

constexpr double degree = std::numbers::pi / 180;

// Contours and the slice that each was drawn on.
struct Drawn {
    std::vector<Points> contours;
    std::vector<std::size_t> slices;

    void circle(const Plane& plane, Vec2 center, double radius, std::size_t slice) {
        const int count = std::max(8, static_cast<int>(radius / 0.15));
        Points points;
        for (int i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * (i + 0.3) / count;
            points.push_back(plane.to_space(center + radius * Vec2{std::cos(angle), 0.9 * std::sin(angle)}));
        }
        contours.push_back(std::move(points));
        slices.push_back(slice);
    }
    // As a file gives it.
    void round(double step) {
        if (step == 0) return;
        for (Points& points : contours) {
            for (Vec3& p : points)
                p = {step * std::round(p.x / step), step * std::round(p.y / step),
                     step * std::round(p.z / step)};
        }
    }
    PlaneGroups group() const {
        std::vector<ContourToPlace> to_place;
        for (const Points& points : contours) to_place.push_back({points});
        return group_planes(to_place, {}, {});
    }
};

enum class Shape { tube, two, small_beside_large, nested, cones };

void draw(Shape shape, const Plane& plane, std::size_t k, Drawn& drawn) {
    const auto t = static_cast<double>(k);
    switch (shape) {
        case Shape::tube:
            drawn.circle(plane, {0.05 * t, 0}, 14, k);
            drawn.circle(plane, {0.05 * t, 0}, 10, k);
            break;
        case Shape::two:
            drawn.circle(plane, {-12, 0}, 5, k);
            drawn.circle(plane, {12, 3}, 4, k);
            break;
        case Shape::small_beside_large:
            drawn.circle(plane, {0, 2 * std::sin(t)}, 60, k);
            drawn.circle(plane, {80, -30}, 2, k);
            drawn.circle(plane, {-70, 10}, 3, k);
            break;
        case Shape::nested:
            for (const double radius : {40.0, 30.0, 12.0, 4.0})
                drawn.circle(plane, {0.4 * radius, 0.1 * radius}, radius, k);
            break;
        case Shape::cones:
            drawn.circle(plane, {0, 0}, 4 + t, k);
            drawn.circle(plane, {40, 0}, 20 - t, k);
            break;
    }
}

// Which contours a group has, however the groups are numbered.
bool as_drawn(const Drawn& drawn, const PlaneGroups& groups) {
    for (std::size_t c = 0; c < drawn.contours.size(); ++c) {
        for (std::size_t d = 0; d < c; ++d) {
            if ((drawn.slices[c] == drawn.slices[d]) != (groups.slice_of[c] == groups.slice_of[d]))
                return false;
        }
    }
    return true;
}

// Whether the planes are those that the points show.
bool on_planes(const Drawn& drawn, const PlaneGroups& groups, double rounding) {
    for (std::size_t c = 0; c < drawn.contours.size(); ++c) {
        const Plane& plane = groups.slices[groups.slice_of[c]];
        for (const Vec3& p : drawn.contours[c]) {
            if (std::abs(plane.signed_distance(p)) > 0.05 + 1.5 * rounding) return false;
        }
    }
    return true;
}

bool are_parallel(const PlaneGroups& groups) {
    return std::all_of(groups.slices.begin(), groups.slices.end(),
                       [&](const Plane& plane) { return plane.normal == groups.slices[0].normal; });
}

TEST(PlaneGrouping, contours_of_slices_that_lean_a_little_stay_together) {
    for (const Shape shape :
         {Shape::tube, Shape::two, Shape::small_beside_large, Shape::nested, Shape::cones}) {
        for (const double rounding : {0.0, 0.001, 0.01, 0.1}) {
            for (const bool oblique : {false, true}) {
                std::string line;
                int all = 0;
                for (const double lean :
                     {0.0, 0.001, 0.003, 0.01, 0.03, 0.06, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0}) {
                    int failed = 0;
                    for (unsigned seed = 0; seed < 10; ++seed) {
                        std::mt19937 random(seed);
                        std::normal_distribution<double> normal(0, std::tan(lean * degree));
                        const Plane stack = make_plane({}, oblique ? Vec3{0.3, -0.2, 1} : Vec3{0, 0, 1});
                        Drawn drawn;
                        for (std::size_t k = 0; k < 16; ++k) {
                            const Vec3 origin = 2.0 * static_cast<double>(k) * stack.normal;
                            const Vec3 n = stack.normal + normal(random) * stack.u + normal(random) * stack.v;
                            draw(shape, make_plane(origin, n), k, drawn);
                        }
                        drawn.round(rounding);
                        const PlaneGroups groups = drawn.group();
                        failed += !as_drawn(drawn, groups) || !on_planes(drawn, groups, rounding) ||
                                  (lean == 0 && !are_parallel(groups));
                    }
                    line += " " + std::to_string(failed);
                    all += failed;
                }
                EXPECT_EQ(all, 0) << static_cast<int>(shape) << " rounding " << rounding
                                  << (oblique ? " oblique" : "") << ":" << line;
            }
        }
    }
}

TEST(PlaneGrouping, contours_of_one_declared_plane_stay_together) {
    for (const double lean : {0.0, 0.001, 0.01, 0.1, 1.0}) {
        for (unsigned seed = 0; seed < 10; ++seed) {
            std::mt19937 random(seed);
            std::normal_distribution<double> normal(0, std::tan(lean * degree));
            Drawn drawn;
            std::vector<Plane> declared;
            for (std::size_t k = 0; k < 16; ++k) {
                declared.push_back(
                    make_plane({0, 0, 2.0 * static_cast<double>(k)}, {normal(random), normal(random), 1}));
                draw(Shape::small_beside_large, declared.back(), k, drawn);
            }
            std::vector<ContourToPlace> to_place;
            for (std::size_t c = 0; c < drawn.contours.size(); ++c)
                to_place.push_back({drawn.contours[c], static_cast<std::int32_t>(drawn.slices[c])});
            const PlaneGroups groups = group_planes(to_place, declared, {});
            EXPECT_TRUE(as_drawn(drawn, groups)) << lean;
            EXPECT_EQ(std::count(groups.spread_mm.begin(), groups.spread_mm.end(), 0.0), 16) << lean;
        }
    }
}

// Planes whose contours lie further apart than the points are off them, and no further.
TEST(PlaneGrouping, C28_planes_that_nearly_agree_stay_apart) {
    for (const double rounding : {0.0, 0.001, 0.01, 0.1}) {
        for (const double apart : {0.004, 0.02, 0.1, 0.5}) {  // mm, at the contours' ends
            if (apart < 4 * rounding) continue;
            for (unsigned seed = 0; seed < 5; ++seed) {
                std::mt19937 random(seed);
                std::uniform_real_distribution<double> unit(-1, 1);
                const Plane first = make_plane({}, {0.3 * unit(random), 0.3 * unit(random), 1});
                Drawn fan, stack;
                for (std::size_t k = 0; k < 12; ++k) {
                    const double t = static_cast<double>(k);
                    draw(Shape::tube, make_plane({}, first.normal + t * apart / 14 * first.u), k, fan);
                    draw(Shape::tube, make_plane(t * apart * first.normal, first.normal), k, stack);
                }
                fan.round(rounding);
                stack.round(rounding);
                EXPECT_TRUE(as_drawn(fan, fan.group())) << "fan " << rounding << ' ' << apart;
                EXPECT_TRUE(as_drawn(stack, stack.group())) << "stack " << rounding << ' ' << apart;
            }
        }
    }
}

}  // namespace
}  // namespace anatomesh::plane_grouping_test
