#include "anatomesh/geom/point_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace anatomesh::point_grid_test {
namespace {

using Found = std::vector<std::pair<std::uint32_t, double>>;

Found by_grid(const PointGrid& grid, Vec3 p, double radius) {
    Found found;
    grid.for_each_within(p, radius,
                         [&](std::uint32_t index, double squared) { found.emplace_back(index, squared); });
    std::sort(found.begin(), found.end());
    return found;
}

Found by_force(const std::vector<Vec3>& points, Vec3 p, double radius) {
    Found found;
    for (std::uint32_t n = 0; n < points.size(); ++n) {
        const double squared = squared_length(points[n] - p);
        if (squared <= radius * radius) found.emplace_back(n, squared);
    }
    return found;
}

// Points anywhere, on cell borders, equal ones, far away; added between queries; radii below and above the
// cell size.
TEST(PointGrid, finds_what_a_search_of_all_points_finds) {
    for (const double cell : {0.1, 1.0, 7.5}) {
        std::mt19937 random(1);
        std::uniform_real_distribution<double> coordinate(-10, 10);
        PointGrid grid(cell, 5);
        std::vector<Vec3> points;
        for (int n = 0; n < 1500; ++n) {
            Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
            if (n % 3 == 0) p = {std::round(p.x), std::round(p.y), cell * std::round(p.z)};
            if (n % 50 == 49) p = points[random() % points.size()];
            if (n % 100 == 0) p = 1e6 * p;
            grid.add(p);
            points.push_back(p);
            const Vec3 q = n % 2 ? p : Vec3{coordinate(random), coordinate(random), coordinate(random)};
            for (const double radius : {0.0, 0.5 * cell, cell, std::min(3 * cell, 4.0), 15.0, 1e5}) {
                const Found expected = by_force(points, q, radius);
                ASSERT_EQ(by_grid(grid, q, radius), expected);
                ASSERT_EQ(grid.any_within(q, radius), !expected.empty());
            }
        }
        ASSERT_EQ(grid.size(), points.size());
        for (std::uint32_t n = 0; n < points.size(); ++n) ASSERT_EQ(grid.point(n), points[n]);
    }
}

TEST(PointGrid, the_order_of_visits_depends_on_the_points_alone) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> coordinate(0, 3);
    PointGrid small(1, 1000), large(1, 1000);
    for (int n = 0; n < 1000; ++n) {
        const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
        small.add(p);
        large.add(p);
    }
    std::vector<std::uint32_t> a, b;
    small.for_each_within({1.5, 1.5, 1.5}, 1, [&](std::uint32_t index, double) { a.push_back(index); });
    large.for_each_within({1.5, 1.5, 1.5}, 1, [&](std::uint32_t index, double) { b.push_back(index); });
    EXPECT_EQ(a, b);
    EXPECT_GT(a.size(), 50u);
}

}  // namespace
}  // namespace anatomesh::point_grid_test
