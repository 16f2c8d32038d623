#include "anatomesh/field/slice/slice_stack.h"

#include <gtest/gtest.h>

#include <numbers>

#include "anatomesh/field/field_fixtures.h"

namespace anatomesh::slice_stack_test {
namespace {

using namespace fixtures;

TEST(SliceStack, distance_to_a_cylinder_at_every_voxel_in_any_direction) {
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{-1, 0, 0}}) {
        SetBuilder builder;
        const Plane plane = make_plane({5, -7, 11}, normal);
        for (int k = 0; k < 5; ++k) {
            Plane at = plane;
            at.origin = plane.to_space({0.1 * k, -0.2 * k}) + 2.5 * k * plane.normal;
            builder.slice(at);
            Ring ring = circle({3 - 0.1 * k, 4 + 0.2 * k}, 10, 2000);
            builder.ring(0, ring);
        }
        RunContext context;
        SliceStackOptions options;
        options.pixel_mm = 0.5;
        const auto stack = slice_stack(builder.set, options, context);
        ASSERT_TRUE(stack.ok());
        const ImageGeometry& geometry = stack.value().geometry;
        ASSERT_EQ(geometry.size[2], 5u);
        const auto distance = distance_image(builder.set, stack.value(), 0, context);
        const LabelMap bits = bit_image(builder.set, stack.value(), context);
        const Vec3 centre = plane.to_space({3, 4});
        for (std::uint32_t k = 0; k < 5; ++k) {
            for (std::uint32_t j = 0; j < geometry.size[1]; ++j) {
                for (std::uint32_t i = 0; i < geometry.size[0]; ++i) {
                    const Vec3 p = geometry.position(i, j, k);
                    EXPECT_NEAR(plane.signed_distance(p), 2.5 * k, 1e-9);
                    const Vec3 w = p - centre;
                    const double wanted = length(w - dot(w, plane.normal) * plane.normal) - 10;
                    const std::size_t n = geometry.index(i, j, k);
                    ASSERT_NEAR(distance[n], wanted, 1e-4);
                    ASSERT_TRUE(distance[n] == 0 || (bits.voxels[n] == 1) == (distance[n] < 0));
                }
            }
        }
    }
}

TEST(SliceStack, bits_fill_the_volume_and_overlaps_are_counted) {
    SetBuilder builder;
    builder.slice(axial(0));
    builder.ring(0, circle({}, 20, 300));
    builder.ring(1, circle({15, 0}, 10, 300));
    RunContext context;
    SliceStackOptions options;
    options.pixel_mm = 0.25;
    const auto stack = slice_stack(builder.set, options, context);
    ASSERT_TRUE(stack.ok());
    std::uint64_t overlaps = 0, second = 0;
    const LabelMap bits = bit_image(builder.set, stack.value(), context, &overlaps);
    for (const std::uint16_t voxel : bits.voxels) second += voxel == 2;
    EXPECT_NEAR(static_cast<double>(second) / 16, 100 * std::numbers::pi, 1.5);
    EXPECT_GT(overlaps, 0u);
    EXPECT_LT(overlaps, second);
}

TEST(SliceStack, missing_slices_are_empty_and_warned_of) {
    SetBuilder builder;
    for (const double z : {-3.0, 0.0, 3.0, 9.0, 12.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 5, 40));
    }
    RunContext context;
    const auto stack = slice_stack(builder.set, {}, context);
    ASSERT_TRUE(stack.ok());
    EXPECT_EQ(stack.value().geometry.size[2], 6u);
    EXPECT_EQ(stack.value().slice[3], SliceStack::none);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-FLD-006");
    const auto distance = distance_image(builder.set, stack.value(), 0, context);
    EXPECT_GT(distance[stack.value().geometry.index(0, 0, 3)], 15);
}

TEST(SliceStack, slices_that_make_no_image_are_refused) {
    RunContext context;
    SetBuilder uneven;
    for (const double z : {0.0, 3.0, 4.0, 7.0}) {
        uneven.slice(axial(z));
        uneven.ring(0, circle({}, 5, 40));
    }
    EXPECT_EQ(slice_stack(uneven.set, {}, context).error().code, "E-FLD-005");
    SetBuilder crossing;
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0}}) {
        crossing.slice(make_plane({}, normal));
        crossing.ring(0, circle({}, 5, 40));
    }
    EXPECT_EQ(slice_stack(crossing.set, {}, context).error().code, "E-FLD-004");
    EXPECT_EQ(slice_stack({}, {}, context).error().code, "E-FLD-001");
    SliceStackOptions fine;
    fine.pixel_mm = 1e-6;
    EXPECT_EQ(slice_stack(ball(10, -9, 1, 30), fine, context).error().code, "E-FLD-006");
}

}  // namespace
}  // namespace anatomesh::slice_stack_test
