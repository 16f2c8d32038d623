#include "anatomesh/refine/segment_vertices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"

namespace anatomesh::segment_vertices_test {
namespace {

using namespace fixtures;

constexpr double gap = 3;

// Discs on planes given one by one, whose normals were rounded; far from where coordinates begin the planes
// lie elsewhere above that than above what is drawn.
ContourSet leaning_stack(Vec3 middle, double lean, std::size_t count, std::mt19937& random) {
    std::uniform_real_distribution<double> off(-lean, lean);
    SetBuilder discs;
    for (std::size_t k = 0; k < count; ++k) {
        const Vec3 normal = normalized({off(random), off(random), 1});
        const Vec3 here = middle + Vec3{0, 0, gap * static_cast<double>(k)};
        Plane plane = make_plane({}, normal);
        plane.origin = dot(here, normal) * normal;
        discs.slice(plane);
        discs.ring(0, circle(plane.to_plane(here), 5 + 0.5 * static_cast<double>(k), 24));
    }
    return discs.set;
}

TEST(SegmentEnds, are_the_vertices_of_neighbouring_points_of_a_contour) {
    std::mt19937 random(3);
    const ContourSet set = leaning_stack({}, 0, 3, random);
    std::vector<std::uint32_t> vertex_of;
    for (std::uint32_t k = 0; k < set.points.size(); ++k) vertex_of.push_back(1000 - 3 * k);
    const auto ends = segment_ends(set, vertex_of);
    ASSERT_EQ(ends.size(), set.points.size());  // closed contours have as many segments as points
    for (std::uint32_t k = 0; k < ends.size(); ++k) {
        const std::uint32_t next = k % 24 == 23 ? k - 23 : k + 1;
        EXPECT_EQ(ends[k][0], 1000 - 3 * k);
        EXPECT_EQ(ends[k][1], 1000 - 3 * next);
    }
}

TEST(SliceWeights, planes_that_lean_a_little_keep_their_order_and_their_flat_ends) {
    std::mt19937 random(11);
    for (const double far : {0.0, 300.0, 3e4}) {
        for (const double lean : {0.0, 1e-6, 1e-4, 1e-3}) {
            SCOPED_TRACE(testing::Message() << far << " mm off, leaning by " << lean);
            constexpr std::size_t count = 6;
            const ContourSet set = leaning_stack({far, -0.7 * far, 10}, lean, count, random);
            FieldOptions options;
            options.caps = EndCaps::flat;
            RunContext context;
            const auto field = make_structure_field(set, options, context);
            ASSERT_TRUE(field.ok());
            const SliceWeights slices =
                weigh_slices(set, slice_facts_of(set, default_max_gap, context), field.value()->flat_ends());
            ASSERT_EQ(slices.planes.size(), count);
            const Vec3 axis = slices.planes.front().normal;
            for (std::size_t k = 0; k < count; ++k) {
                const bool end = k == 0 || k + 1 == count;
                EXPECT_EQ(slices.weights[k] == 0, end) << k;
                EXPECT_NEAR(dot(slices.planes[k].origin - slices.planes[0].origin, axis),
                            gap * static_cast<double>(k), 0.01 * gap);
                EXPECT_NEAR(set.slices[k].plane.signed_distance(slices.planes[k].origin), 0, 1e-9);
            }
        }
    }
}

// Discs in planes about an axis: each says something within its contours' box, and is in the list as it is.
TEST(SliceWeights, planes_that_cross_have_extents_and_no_stack) {
    SetBuilder discs;
    constexpr int count = 5;
    for (int k = 0; k < count; ++k) {
        const double angle = std::numbers::pi * k / count;
        const Plane plane = make_plane({1, 2, 3}, {std::cos(angle), std::sin(angle), 0});
        discs.slice(plane);
        discs.ring(0, circle({0.5, 0}, 5 + k, 24));
    }
    const ContourSet set = std::move(discs.set);
    RunContext context;
    const SliceWeights slices = weigh_slices(set, slice_facts_of(set, default_max_gap, context), {});
    ASSERT_EQ(slices.planes.size(), set.slices.size());
    ASSERT_EQ(slices.extents.size(), set.slices.size());
    EXPECT_TRUE(slices.sides.stack.heights.empty());
    EXPECT_EQ(slices.sides.planes.size(), set.slices.size());
    for (std::size_t k = 0; k < set.slices.size(); ++k) {
        EXPECT_EQ(slices.planes[k].origin, set.slices[k].plane.origin);
        EXPECT_GT(slices.weights[k], 0);
        for (const Vec3& p : set.points_of(set.contours[k]))
            EXPECT_TRUE(slices.extents[k].contains(slices.planes[k].to_plane(p)));
        const Vec2 size = slices.extents[k].high - slices.extents[k].low;
        EXPECT_NEAR(size.x, 2.0 * (5 + static_cast<double>(k)), 0.1);
    }
}

}  // namespace
}  // namespace anatomesh::segment_vertices_test
