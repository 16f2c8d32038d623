#include "anatomesh/contour/overlay/structure_overlap.h"

#include <gtest/gtest.h>

#include <random>

namespace anatomesh::structure_overlap_test {
namespace {

// Quadrangles of a jittered grid, each a structure of its own, with common vertices.
ContourSet jittered_grid(std::mt19937& random, std::uint32_t count) {
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    std::vector<Vec3> nodes;
    for (std::uint32_t j = 0; j <= count; ++j)
        for (std::uint32_t i = 0; i <= count; ++i)
            nodes.push_back({i + jitter(random), j + jitter(random), 4});
    ContourSet set;
    Slice slice;
    slice.plane = make_plane({0, 0, 4}, {0, 0, 1});
    slice.name = "z = 4";
    for (std::uint32_t j = 0; j < count; ++j)
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t at = j * (count + 1) + i;
            set.contours.push_back({static_cast<std::uint32_t>(set.structures.size()), 0,
                                    static_cast<std::uint32_t>(set.points.size()), 4});
            set.structures.push_back({static_cast<std::int32_t>(set.structures.size()) + 1, "", {}});
            for (const std::uint32_t node : {at, at + 1, at + count + 2, at + count + 1})
                set.points.push_back(nodes[node]);
        }
    slice.contour_count = static_cast<std::uint32_t>(set.contours.size());
    set.slices.push_back(slice);
    return set;
}

Vec3 middle_of(const ContourSet& set, const Contour& contour) {
    Vec3 sum{0, 0, 0};
    for (const Vec3& p : set.points_of(contour)) sum = sum + p;
    return (1.0 / contour.point_count) * sum;
}

TEST(StructureOverlap, cells_with_common_vertices_exclude_each_other_until_one_of_them_changes) {
    std::mt19937 random(5);
    for (int round = 0; round < 60; ++round) {
        const std::uint32_t count = 2 + random() % 4;
        const ContourSet grid = jittered_grid(random, count);
        EXPECT_FALSE(find_overlap(grid));
        const std::uint32_t one = random() % (count * count);

        ContourSet moved = grid;
        for (std::uint32_t p = 0; p < 4; ++p) {
            Vec3& point = moved.points[moved.contours[one].first_point + p];
            point = middle_of(grid, grid.contours[one]) + 1.2 * (point - middle_of(grid, grid.contours[one]));
        }
        const auto overlap = find_overlap(moved);
        ASSERT_TRUE(overlap);
        EXPECT_TRUE(overlap->first == one || overlap->second == one);
        EXPECT_GT(overlap->area_mm2, 0.01);

        // One that lies within another meets no contour.
        ContourSet nested = grid;
        nested.structures.push_back({1000, "", {}});
        nested.contours.push_back({count * count, 0, static_cast<std::uint32_t>(nested.points.size()), 3});
        ++nested.slices[0].contour_count;
        const Vec3 middle = middle_of(grid, grid.contours[one]);
        for (const Vec3 off : {Vec3{0, 0, 0}, Vec3{0.01, 0, 0}, Vec3{0, 0.01, 0}})
            nested.points.push_back(middle + off);
        const auto within = find_overlap(nested);
        ASSERT_TRUE(within);
        EXPECT_EQ(within->first, one);
        EXPECT_EQ(within->second, count * count);
        EXPECT_NEAR(within->area_mm2, 5e-5, 1e-9);

        // A vertex that the other side of the wall does not have.
        ContourSet split = grid;
        const std::uint32_t left = count * (random() % count);  // its right wall has another cell beyond
        Contour& contour = split.contours[left];
        std::vector<Vec3> points(split.points_of(contour).begin(), split.points_of(contour).end());
        points.insert(points.begin() + 2, 0.5 * (points[1] + points[2]));
        contour.first_point = static_cast<std::uint32_t>(split.points.size());
        contour.point_count = 5;
        split.points.insert(split.points.end(), points.begin(), points.end());
        const auto wall = find_overlap(split);
        ASSERT_TRUE(wall);
        EXPECT_NEAR(wall->area_mm2, 0, 1e-9);
    }
}

}  // namespace
}  // namespace anatomesh::structure_overlap_test
