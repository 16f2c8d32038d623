#include "anatomesh/mesh/shape/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh::quality_test {
namespace {

using Points = std::array<Vec3, 4>;

const Points regular{{{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}}};
const Points corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

double ratio(const Points& p) {
    return radius_edge_ratio(p[0], p[1], p[2], p[3]);
}
DihedralRange range_of(const Points& p) {
    return dihedral_range(p[0], p[1], p[2], p[3]);
}

// Of the half planes from each edge through the other two vertices.
std::array<double, 6> angles(const Points& p) {
    std::array<double, 6> degrees;
    for (std::size_t e = 0; e < 6; ++e) {
        const auto at = [&](std::size_t edge, std::size_t end) {
            return p[static_cast<std::size_t>(cell_edges[edge][end])];
        };
        const Vec3 from = at(e, 0), along = normalized(at(e, 1) - from);
        const auto across = [&](Vec3 q) { return q - from - dot(q - from, along) * along; };
        const Vec3 one = across(at(5 - e, 0)), other = across(at(5 - e, 1));
        degrees[e] = std::atan2(length(cross(one, other)), dot(one, other)) * 180 / std::acos(-1.0);
    }
    return degrees;
}

Points random_cell(std::mt19937& random) {
    Points p;
    for (Vec3& point : p) {
        point = {static_cast<double>(random() % 2001) - 1000, static_cast<double>(random() % 2001) - 1000,
                 static_cast<double>(random() % 2001) - 1000};
    }
    return p;
}

TEST(Quality, regular_cell) {
    EXPECT_NEAR(ratio(regular), std::sqrt(6.0) / 4, 1e-15);
    EXPECT_NEAR(range_of(regular).smallest, 70.528779365509308, 1e-12);
    EXPECT_NEAR(range_of(regular).largest, 70.528779365509308, 1e-12);
}

TEST(Quality, corner_of_a_cube) {
    EXPECT_NEAR(ratio(corner), std::sqrt(3.0) / 2, 1e-15);
    EXPECT_DOUBLE_EQ(signed_volume(corner[0], corner[1], corner[2], corner[3]), 1.0 / 6);
    const double slanted = std::acos(1 / std::sqrt(3.0)) * 180 / std::acos(-1.0);
    EXPECT_NEAR(range_of(corner).smallest, slanted, 1e-12);
    EXPECT_NEAR(range_of(corner).largest, 90, 1e-12);
    EXPECT_EQ(circumcenter(corner[0], corner[1], corner[2], corner[3]), (Vec3{0.5, 0.5, 0.5}));
}

TEST(Quality, flat_and_pointlike_cells) {
    const Points flat{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
    EXPECT_TRUE(std::isinf(ratio(flat)));
    const DihedralRange range = range_of(flat);
    EXPECT_EQ(range.smallest, 0.0);
    EXPECT_EQ(range.largest, 180.0);
    EXPECT_TRUE(std::isinf(ratio({{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}}})));
}

TEST(Quality, circumcenter_is_as_far_from_every_vertex) {
    std::mt19937 random(3);
    for (int trial = 0; trial < 1000; ++trial) {
        const Points p = random_cell(random);
        if (std::abs(signed_volume(p[0], p[1], p[2], p[3])) < 1e4) continue;
        const Vec3 center = circumcenter(p[0], p[1], p[2], p[3]);
        const double radius = length(center - p[0]);
        for (const Vec3& point : p) EXPECT_NEAR(length(center - point), radius, 1e-9 * radius);
    }
}

// Relabelling, mirroring, moving and scaling leave the shape measures alone; the range agrees with all six
// angles.
TEST(Quality, laws_of_shape) {
    std::mt19937 random(5);
    for (int trial = 0; trial < 1000; ++trial) {
        const Points p = random_cell(random);
        if (std::abs(signed_volume(p[0], p[1], p[2], p[3])) < 1e4) continue;
        const Points turned{{p[2], p[0], p[3], p[1]}};
        Points other;
        for (std::size_t i = 0; i < 4; ++i)
            other[i] = Vec3{16, 32, -64} + 0.5 * Vec3{p[i].x, -p[i].y, p[i].z};
        EXPECT_NEAR(ratio(p), ratio(turned), 1e-9 * ratio(p));
        EXPECT_NEAR(ratio(p), ratio(other), 1e-9 * ratio(p));
        const std::array<double, 6> all = angles(p);
        const DihedralRange range = range_of(p), mirrored = range_of(other);
        EXPECT_NEAR(range.smallest, mirrored.smallest, 1e-9);
        EXPECT_NEAR(range.largest, mirrored.largest, 1e-9);
        EXPECT_NEAR(range.smallest, *std::min_element(all.begin(), all.end()), 1e-9);
        EXPECT_NEAR(range.largest, *std::max_element(all.begin(), all.end()), 1e-9);
        EXPECT_NEAR(signed_volume(p[0], p[1], p[2], p[3]), -signed_volume(p[1], p[0], p[2], p[3]), 1e-3);
    }
}

}  // namespace
}  // namespace anatomesh::quality_test
