#include "anatomesh/live/draw/area/structure_rings.h"

#include <gtest/gtest.h>

#include <limits>

#include "anatomesh/live/draw/area/draw_fixtures.h"

namespace anatomesh::structure_rings_test {
namespace {

using namespace draw_fixtures;

std::string code_of(const std::vector<Polygon>& polygons, double off = 0, const Plane& plane = {}) {
    std::vector<std::vector<Vec3>> in_space;
    for (const Polygon& polygon : polygons) {
        std::vector<Vec3>& points = in_space.emplace_back();
        for (const Vec2 p : polygon) points.push_back({p.x, p.y, 0});
        if (!points.empty()) points[0].z += off;
    }
    const Result<StructureRings> made = make_structure_rings(in_space, plane);
    return made.ok() ? "" : made.error().code;
}

TEST(StructureRings, keeps_points_bit_for_bit_on_any_plane) {
    for (int seed = 0; seed < 200; ++seed) {
        Random random(static_cast<unsigned>(seed));
        const Plane plane = random_plane(random);
        std::vector<std::vector<Vec3>> in_space;
        for (int n = 0; n < 3; ++n) {
            std::vector<Vec3>& points = in_space.emplace_back();
            for (const Vec2 p : random_star(random, {50.0 * n, 0}, 20)) {
                points.push_back(plane.to_space(p) + uniform(random, -0.009, 0.009) * plane.normal);
            }
        }
        const Result<StructureRings> made = make_structure_rings(in_space, plane);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        for (std::size_t r = 0; r < 3; ++r) {
            EXPECT_EQ(made.value().rings[r].points, in_space[r]);
            EXPECT_EQ(made.value().rings[r].source, r);
        }
        expect_sound(made.value());
    }
}

TEST(StructureRings, refuses_what_is_no_ring) {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {0, 10}}}), "");
    EXPECT_EQ(code_of({}), "");
    for (const double bad : {nan, infinite, -infinite, 1.1e7}) {
        EXPECT_EQ(code_of({{{0, 0}, {10, bad}, {0, 10}}}), "E-LIV-001") << bad;
        Plane plane;
        plane.origin.x = bad;
        EXPECT_EQ(code_of({}, 0, plane), "E-LIV-001") << bad;
    }
    EXPECT_EQ(code_of({{}}), "E-LIV-002");
    EXPECT_EQ(code_of({{{0, 0}}}), "E-LIV-002");
    EXPECT_EQ(code_of({{{0, 0}, {1, 0}}}), "E-LIV-002");
    for (const double off : {0.011, -0.011, 5.0})
        EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {0, 10}}}, off), "E-LIV-003");
    EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {0, 10}}}, 0.009), "");
    Plane skew;
    skew.v = {0.1, 1, 0};
    EXPECT_EQ(code_of({}, 0, skew), "E-LIV-006");
    Plane mirrored;
    mirrored.normal = {0, 0, -1};
    EXPECT_EQ(code_of({}, 0, mirrored), "E-LIV-006");
}

TEST(StructureRings, refuses_a_ring_that_meets_itself) {
    EXPECT_EQ(code_of({{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}), "E-LIV-004");           // an eight
    EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {10, 0}, {0, 10}}}), "E-LIV-004");            // a point twice
    EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {0, 10}, {0, 0}}}), "E-LIV-004");             // the first repeated
    EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {10, 10}, {5, 0}, {0, 10}}}), "E-LIV-004");   // a vertex on an edge
    EXPECT_EQ(code_of({{{0, 0}, {10, 0}, {10, 10}, {10, 0}, {5, -9}}}), "E-LIV-004");  // a spike
    EXPECT_EQ(code_of({{{0, 0}, {4, 0}, {4, 4}, {8, 4}, {4, 4}, {0, 4}}}), "E-LIV-004");  // a hair
    EXPECT_EQ(code_of({{{-4, -4}, {4, -4}, {0, 0}, {4, 4}, {-4, 4}, {0, 0}}}),
              "E-LIV-004");  // touches in a point
}

TEST(StructureRings, lets_rings_touch_in_points_but_not_cross) {
    const Polygon square{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    EXPECT_EQ(code_of({square, {{10, 10}, {20, 10}, {20, 20}}}), "");  // in a vertex
    EXPECT_EQ(code_of({square, {{10, 5}, {20, 0}, {20, 20}}}), "");    // a vertex on an edge
    EXPECT_EQ(code_of({square, {{0, 0}, {5, 2}, {2, 5}}}), "");        // a hole at a corner
    EXPECT_EQ(code_of({square, {{2, 2}, {4, 2}, {4, 4}}}), "");
    EXPECT_EQ(code_of({square, {{5, 5}, {15, 5}, {15, 6}, {5, 6}}}), "E-LIV-005");
    EXPECT_EQ(code_of({square, {{10, 2}, {20, 2}, {20, 8}, {10, 8}}}), "E-LIV-005");  // along an edge
    EXPECT_EQ(code_of({square, square}), "E-LIV-005");
    // Through vertices alone: each contact is a touch, and yet the rings cross.
    EXPECT_EQ(code_of({square, {{0, 0}, {15, 3}, {10, 10}, {4, 12}}}), "E-LIV-005");
    EXPECT_EQ(code_of({square, {{5, 5}, {10, 4}, {15, 5}, {10, 6}}}), "E-LIV-005");
}

TEST(StructureRings, a_fault_has_its_place) {
    const Result<StructureRings> made = make_structure_rings(
        std::vector<std::vector<Vec3>>{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{5, 0, 0}, {6, 0, 0}, {5, 1, 2}}},
        {});
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().place.contour, "1, point 2");
    EXPECT_EQ(made.error().place.value, "2 mm");
    EXPECT_FALSE(made.error().next_step.empty());
}

}  // namespace
}  // namespace anatomesh::structure_rings_test
