#include "anatomesh/field/general_field.h"

#include <gtest/gtest.h>

#include <random>

#include "anatomesh/field/field_fixtures.h"

namespace anatomesh {
namespace {

using namespace fixtures;

constexpr double radius = 20;

// A ball on three stacks that cross, or on planes through one axis.
ContourSet crossing_stacks() {
    SetBuilder builder;
    for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{0, 1, 0.1}, Vec3{1, 0.2, 0.1}}) {
        const Vec3 n = normalized(normal);
        for (double h = -18; h < radius; h += 4) {
            builder.slice(make_plane(h * n, n));
            builder.ring(0, circle({}, std::sqrt(radius * radius - h * h), 180, 0.3 * h));
        }
    }
    return builder.set;
}

ContourSet rotational_sweep() {
    SetBuilder builder;
    for (int k = 0; k < 12; ++k) {
        const double angle = std::numbers::pi * k / 12;
        builder.slice(make_plane({0, 0, 0}, {std::cos(angle), std::sin(angle), 0}));
        builder.ring(0, circle({}, radius, 180, 0.01));
    }
    return builder.set;
}

std::shared_ptr<const StructureField> field_of(const ContourSet& set) {
    RunContext context;
    return make_structure_field(set, {}, context).value();
}

TEST(GeneralField, zero_exactly_at_every_contour_vertex) {
    for (const ContourSet& set : {crossing_stacks(), rotational_sweep()}) {
        const auto field = field_of(set);
        for (const Vec3& p : set.points) ASSERT_EQ(field->value(0, p), 0.0);
    }
}

TEST(GeneralField, C24_C27_the_ball_comes_back_inside_and_outside_near_its_surface) {
    std::mt19937 random(31);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const ContourSet& set : {crossing_stacks(), rotational_sweep()}) {
        const auto field = field_of(set);
        std::vector<std::uint32_t> members;
        for (int i = 0; i < 4000; ++i) {
            const Vec3 direction = normalized({unit(random), unit(random), unit(random)});
            field->members((radius - 1.5) * direction, members);
            ASSERT_EQ(members.size(), 1u) << direction.x << " " << direction.y << " " << direction.z;
            field->members((radius + 1.5) * direction, members);
            ASSERT_TRUE(members.empty()) << direction.x << " " << direction.y << " " << direction.z;
        }
        field->members({}, members);
        EXPECT_EQ(members.size(), 1u);
    }
}

TEST(GeneralField, on_a_plane_away_from_others_the_drawn_region_holds) {
    SetBuilder builder;
    const Ring notched{{-20, -20}, {20, -20}, {20, 20}, {0, 0}, {-20, 20}};
    builder.slice(axial(0));
    builder.ring(0, notched);
    builder.slice({{100, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}});  // crosses the first plane far away
    builder.ring(0, circle({}, 10, 40));
    const auto field = field_of(builder.set);
    EXPECT_LT(field->value(0, {0, -1, 0}), 0);
    EXPECT_GT(field->value(0, {0, 1, 0}), 0);
    EXPECT_LT(field->value(0, {100, 0, 9.9}), 0);
    EXPECT_GT(field->value(0, {100, 0, 10.1}), 0);
}

TEST(GeneralField, far_from_all_planes_is_outside) {
    const auto field = field_of(crossing_stacks());
    std::vector<StructureField::Near> near;
    field->values_near({1000, 0, 0}, near);
    EXPECT_TRUE(near.empty());
    EXPECT_EQ(field->value(0, {1000, 0, 0}), field->clamp());
}

}  // namespace
}  // namespace anatomesh
