// Laws of the sections of tetrahedra by planes.
#include "anatomesh/geom/plane_sections.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace anatomesh::plane_sections_test {
namespace {

using Corners = std::array<Vec3, 4>;

// The cube from (0, 0, 0) to (1, 1, 1), cut along its diagonal into six.
std::vector<Corners> cube() {
    std::vector<Corners> cells;
    const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    std::array<std::size_t, 3> order{0, 1, 2};
    do {
        const Vec3 a = axes[order[0]], b = a + axes[order[1]];
        cells.push_back({Vec3{0, 0, 0}, a, b, Vec3{1, 1, 1}});
    } while (std::next_permutation(order.begin(), order.end()));
    return cells;
}

// Of the plane within the cube, by clipping a large square by its six sides.
double area_in_cube(const Plane& plane) {
    std::vector<Vec3> polygon;
    for (const Vec2 q : {Vec2{-9, -9}, Vec2{9, -9}, Vec2{9, 9}, Vec2{-9, 9}})
        polygon.push_back(plane.to_space(q));
    for (int side = 0; side < 6; ++side) {
        const auto inside = [&](Vec3 p) {
            const double x = side / 2 == 0 ? p.x : side / 2 == 1 ? p.y : p.z;
            return side % 2 ? 1 - x : x;
        };
        std::vector<Vec3> rest;
        for (std::size_t n = 0; n < polygon.size(); ++n) {
            const Vec3 p = polygon[n], q = polygon[(n + 1) % polygon.size()];
            const double at_p = inside(p), at_q = inside(q);
            if (at_p >= 0) rest.push_back(p);
            if ((at_p < 0) != (at_q < 0)) rest.push_back(p + at_p / (at_p - at_q) * (q - p));
        }
        polygon = rest;
    }
    double area = 0;
    for (std::size_t n = 2; n < polygon.size(); ++n)
        area += 0.5 * length(cross(polygon[n - 1] - polygon[0], polygon[n] - polygon[0]));
    return area;
}

struct Sum {
    double area = 0;
    int sections = 0, facets = 0;
};

Sum sum_of(const std::vector<Plane>& planes, const std::vector<Box2>& extents) {
    Sum sum;
    for (const Corners& cell : cube()) {
        for_each_section(cell, {planes, extents, 1e-12}, [&](std::uint32_t k, const PlaneSection& section) {
            sum.area += section.area;
            ++(section.facet == PlaneSection::no_facet ? sum.sections : sum.facets);
            EXPECT_NEAR(planes[k].signed_distance(section.middle), 0, 1e-12);
            EXPECT_TRUE((Box3{{0, 0, 0}, {1, 1, 1}}).grown(1e-12).contains(section.middle));
        });
    }
    return sum;
}

const Box2 everywhere{{-99, -99}, {99, 99}};

TEST(PlaneSections, those_of_all_cells_of_a_cube_are_its_own) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    int cut = 0;
    for (int n = 0; n < 300; ++n) {
        const Plane plane = make_plane(
            Vec3{0.5, 0.5, 0.5} + 0.7 * Vec3{coordinate(random), coordinate(random), coordinate(random)},
            {coordinate(random), coordinate(random), coordinate(random)});
        const double area = area_in_cube(plane);
        cut += area > 0;
        EXPECT_NEAR(sum_of({plane}, {everywhere}).area, area, 1e-12);
    }
    EXPECT_GT(cut, 200);
    EXPECT_LT(cut, 300);
}

TEST(PlaneSections, planes_through_vertices_edges_and_facets) {
    // Through a side: a facet of each of two cells.
    Sum sum = sum_of({make_plane({}, {0, 0, 1})}, {everywhere});
    EXPECT_NEAR(sum.area, 1, 1e-12);
    EXPECT_EQ(sum.facets, 2);
    EXPECT_EQ(sum.sections, 0);
    // Between cells: facets of both.
    sum = sum_of({make_plane({}, {1, -1, 0})}, {everywhere});
    EXPECT_NEAR(sum.area, 2 * std::sqrt(2), 1e-12);
    EXPECT_EQ(sum.facets, 4);
    // Through the diagonal and no other vertex, through one vertex, and beside all.
    const Plane through_diagonal = make_plane({}, {3, -1, -2});
    sum = sum_of({through_diagonal}, {everywhere});
    EXPECT_NEAR(sum.area, area_in_cube(through_diagonal), 1e-12);
    EXPECT_EQ(sum.facets, 0);
    EXPECT_EQ(sum_of({make_plane({}, {1, 1, 1})}, {everywhere}).sections, 0);
    EXPECT_EQ(sum_of({make_plane({2, 0, 0}, {1, 0, 0})}, {everywhere}).sections, 0);
}

TEST(PlaneSections, a_plane_ends_where_its_extent_does) {
    const std::vector<Plane> planes{make_plane({0, 0, 0.5}, {0, 0, 1}), make_plane({0.4, 0, 0}, {1, 0, 0})};
    const Sum both = sum_of(planes, {everywhere, everywhere}), one = sum_of(planes, {everywhere, Box2{}});
    EXPECT_NEAR(both.area, 2, 1e-12);
    EXPECT_NEAR(one.area, 1, 1e-12);
    EXPECT_EQ(sum_of(planes, {Box2{}, Box2{}}).sections, 0);
}

}  // namespace
}  // namespace anatomesh::plane_sections_test
