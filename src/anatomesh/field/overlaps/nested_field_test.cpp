// Chambers in walls, drawn as two outlines, of which the chamber keeps what both have.
#include "anatomesh/field/overlaps/nested_field.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/field/voxel_topology_for_test.h"
#include "anatomesh/overlaps/priority.h"

namespace anatomesh::nested_field_test {
namespace {

using namespace fixtures;

// A pipe that moves `step` mm from each slice to the next, 4 mm apart; its wall as thick as given, or a solid
// rod of its own beside it that does not overlap.
ContourSet pipe(double step, double wall, bool with_planes_across = false) {
    SetBuilder builder;
    for (int k = 0; k < 9; ++k) {
        builder.slice(make_plane({0, 0, 4.0 * k}, {0, 0, 1}));
        builder.ring(0, circle({step * k, 0}, 10, 40));
        builder.ring(1, circle({step * k, 0}, 10 + wall, 48));
    }
    if (with_planes_across) {
        // The plane of the axis, to where the stack ends.
        builder.slice(make_plane({0, 0, 0}, {0, 1, 0}));
        const Plane& plane = builder.set.slices.back().plane;
        const auto outline = [&](double radius) {
            const double low = -0.5 * step, high = 8.5 * step;
            Ring ring{plane.to_plane({low - radius, 0, -2}), plane.to_plane({low + radius, 0, -2}),
                      plane.to_plane({high + radius, 0, 34}), plane.to_plane({high - radius, 0, 34})};
            return area_of(ring) > 0 ? ring : reversed(ring);
        };
        builder.ring(0, outline(10));
        builder.ring(1, outline(10 + wall));
    }
    for (std::size_t s = 0; s < builder.set.slices.size(); ++s)
        builder.set.slices[s].name = "slice " + std::to_string(s);
    return builder.set;
}

ContourSet given(const ContourSet& drawn, const std::vector<std::uint32_t>& order) {
    RunContext context;
    return give_overlaps(drawn, order, context).value().kept;
}

std::shared_ptr<const StructureField> field_of(const ContourSet& set) {
    RunContext context;
    return make_structure_field(set, {}, context).value();
}

// The field of one structure alone.
class Alone final : public StructureField {
  public:
    Alone(const StructureField& field, std::uint32_t structure) : field_(field), structure_(structure) {}
    double value(std::uint32_t, Vec3 p) const override { return field_.value(structure_, p); }
    void values_near(Vec3, std::vector<Near>&) const override {}
    void members(Vec3, std::vector<std::uint32_t>&) const override {}
    double interface_distance(Vec3) const override { return 0; }
    double union_value(Vec3 p) const override { return field_.union_value(p); }
    double slice_spacing() const override { return field_.slice_spacing(); }
    double clamp() const override { return field_.clamp(); }
    Box3 box() const override { return field_.box(); }

  private:
    const StructureField& field_;
    std::uint32_t structure_;
};

TEST(NestedField, a_wall_has_no_holes_however_thin_it_is_and_far_it_moves) {
    for (const bool across : {false, true}) {
        for (const double step : {0.0, 2.0, 4.0, 6.0}) {
            for (const double wall : {2.0, 3.0}) {
                const ContourSet set = given(pipe(step, wall, across), {0});
                ASSERT_TRUE(set.overlapping);
                const auto field = field_of(set);
                const Topology topology = Voxels(Alone(*field, 1), 0.55).topology();
                EXPECT_EQ(topology, (Topology{1, 1, 0})) << step << " " << wall << " " << across;
            }
        }
    }
}

TEST(NestedField, queries_agree_with_each_other_and_structures_exclude_each_other) {
    const ContourSet drawn = pipe(3, 2, true);
    for (const std::vector<std::uint32_t>& order : {std::vector<std::uint32_t>{0}, {0, 1}}) {
        const auto field = field_of(given(drawn, order)),
                   inner = field_of(choose_structures(drawn, std::vector<std::uint32_t>{0})),
                   outer = field_of(choose_structures(drawn, std::vector<std::uint32_t>{1}));
        EXPECT_TRUE(field->exclusive());
        std::mt19937 random(1);
        std::uniform_real_distribution<double> x(-15, 40), y(-15, 15), z(-4, 36);
        for (int n = 0; n < 4000; ++n) {
            const Vec3 p{x(random), y(random), z(random)};
            std::vector<std::uint32_t> members, again;
            field->members(p, members);
            EXPECT_LE(members.size(), 1u);
            const double distance = field->members_and_distance(p, again);
            EXPECT_EQ(members, again);
            EXPECT_EQ(distance, field->interface_distance(p));
            std::vector<StructureField::Near> near;
            field->values_near(p, near);
            for (const StructureField::Near& one : near)
                EXPECT_EQ(one.value, field->value(one.structure, p)) << one.structure;
            for (std::uint32_t s = 0; s < 2; ++s) {
                const bool inside = field->value(s, p) < 0;
                EXPECT_EQ(inside, members == std::vector<std::uint32_t>{s});
                EXPECT_EQ(field->value_within(s, p, 0) < 0, inside);
            }
            EXPECT_EQ(field->value(0, p), inner->value(0, p));
            EXPECT_EQ(field->value(1, p), std::max(outer->value(0, p), -inner->value(0, p)));
            EXPECT_NEAR(field->union_value(p), std::min(outer->value(0, p), inner->value(0, p)), 1e-6);
            EXPECT_EQ(field->union_value(p) < 0, !members.empty());
        }
    }
}

TEST(NestedField, volumes_are_those_drawn_less_those_before) {
    RunContext context;
    const ContourSet drawn = pipe(3, 3), set = given(drawn, {0});
    const auto whole = field_volumes(*field_of(drawn), 2, {}, context).value();
    const auto parts = field_volumes(*field_of(set), 2, {}, context).value();
    EXPECT_NEAR(parts[0].by_field, whole[0].by_field, 2e-3 * whole[0].by_field);
    EXPECT_NEAR(parts[1].by_field, whole[1].by_field - whole[0].by_field, 2e-3 * parts[1].by_field);
    EXPECT_NEAR(parts[0].by_slices, whole[0].by_slices, 1e-9 * whole[0].by_slices);
    EXPECT_NEAR(parts[1].by_slices, whole[1].by_slices - whole[0].by_slices, 1e-9 * whole[1].by_slices);
}

TEST(NestedField, structures_side_by_side_stay_a_partition) {
    SetBuilder builder;
    for (int k = 0; k < 5; ++k) {
        builder.slice(make_plane({0, 0, 4.0 * k}, {0, 0, 1}));
        builder.ring(0, circle({0, 0}, 10, 40));
        builder.ring(1, circle({18, 0}, 10, 40, 0.1));
    }
    EXPECT_FALSE(given(builder.set, {0}).overlapping);
}

TEST(NestedField, of_some_slices_is_of_those_of_what_was_drawn) {
    const ContourSet set = given(pipe(3, 3), {0});
    const std::vector<std::uint32_t> some{0, 2, 4, 5, 6, 7};
    const ContourSet part = chosen_slices(set, some);
    ASSERT_TRUE(part.overlapping);
    for (const ContourSet& level : part.overlapping->levels) {
        ASSERT_EQ(level.slices.size(), some.size());
        for (std::size_t n = 0; n < some.size(); ++n)
            EXPECT_EQ(level.slices[n].name, set.slices[some[n]].name);
    }
}

// Neighbours that share a wall, and in one of them a lesion far from it.
TEST(NestedField, neighbours_keep_their_wall_where_something_lies_in_one_of_them) {
    SetBuilder builder;
    for (int k = 0; k < 7; ++k) {
        builder.slice(make_plane({0, 0, 4.0 * k}, {0, 0, 1}));
        const double wall = 3 * std::sin(1.5 * k);
        builder.ring(0, {{-20, -15}, {wall, -15}, {wall, 15}, {-20, 15}});
        builder.ring(1, {{wall, -15}, {20, -15}, {20, 15}, {wall, 15}});
        if (k >= 2 && k <= 4) builder.ring(2, circle({12, 0}, 4, 24));
        builder.set.slices.back().name = "slice " + std::to_string(k);
    }
    const ContourSet set = given(builder.set, {2});
    ASSERT_TRUE(set.overlapping);
    EXPECT_EQ(set.overlapping->levels.size(), 2u);
    const auto field = field_of(set);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> x(-19, 19), y(-14, 14), z(0, 24);
    std::vector<std::uint32_t> members;
    for (int n = 0; n < 20000; ++n) {
        field->members({x(random), y(random), z(random)}, members);
        EXPECT_EQ(members.size(), 1u);
    }
    // Without the slices that have it, it is nowhere.
    const std::vector<std::uint32_t> without{0, 1, 5, 6};
    const auto rest = field_of(chosen_slices(set, without));
    rest->members({12, 0, 12}, members);
    EXPECT_NE(members, std::vector<std::uint32_t>{2});
    EXPECT_GT(rest->value(2, {12, 0, 12}), 0);
    RunContext context;
    EXPECT_EQ(field_volumes(*rest, 3, {}, context).value()[2].by_field, 0);
}

TEST(NestedField, a_tumour_at_the_capsule_is_parted_from_its_organ_as_neighbours_are) {
    SetBuilder builder;
    for (int k = -3; k <= 3; ++k) {
        builder.slice(make_plane({0, 0, 4.0 * k}, {0, 0, 1}));
        const Ring whole = circle({0, 0}, std::sqrt(400.0 - 16.0 * k * k), 60);
        Ring part;
        for (const Vec2 p : whole) {
            if (p.x >= 8) part.push_back(p);
        }
        std::sort(part.begin(), part.end(), [](Vec2 a, Vec2 b) { return a.y < b.y; });
        builder.ring(0, whole);
        builder.ring(1, part);
        builder.set.slices.back().name = "slice " + std::to_string(k);
    }
    EXPECT_FALSE(given(builder.set, {1}).overlapping);
}

// A lesion drawn every millimetre in an organ drawn every four, alone and beside a rod: what lies between the
// organ's slices is the organ's, whatever else is drawn there.
TEST(NestedField, slices_that_draw_others_alone_say_nothing_of_a_structure) {
    for (const bool beside : {false, true}) {
        SetBuilder builder;
        for (int z = 0; z <= 24; ++z) {
            const bool of_organ = z % 4 == 0, of_lesion = z >= 8 && z <= 16;
            if (!of_organ && !of_lesion) continue;
            builder.slice(make_plane({0, 0, 1.0 * z}, {0, 0, 1}));
            builder.set.slices.back().name = "slice " + std::to_string(z);
            if (of_lesion) builder.ring(0, circle({0, 0}, 8, 60));
            if (of_organ) builder.ring(1, circle({0, 0}, 20, 120));
            if (of_organ && beside) builder.ring(2, circle({40, 0}, 5, 40));
        }
        const ContourSet set = given(builder.set, {});
        ASSERT_TRUE(set.overlapping);
        const auto field = field_of(set);
        for (const double z : {0.0, 2.0, 9.0, 10.0, 11.5, 15.0, 24.0}) {
            for (const double x : {10.0, 19.0}) {
                std::vector<std::uint32_t> members;
                field->members({x, 0, z}, members);
                EXPECT_EQ(members, (std::vector<std::uint32_t>{1})) << x << " " << z;
            }
        }
        RunContext context;
        const auto volumes = field_volumes(*field, beside ? 3 : 2, {}, context).value();
        const double lesion = std::numbers::pi * 64 * 9, organ = std::numbers::pi * 400 * 28 - lesion;
        EXPECT_NEAR(volumes[0].by_field, lesion, 0.01 * lesion);
        EXPECT_NEAR(volumes[1].by_field, organ, 0.01 * organ);
        EXPECT_NEAR(volumes[0].by_slices, lesion, 0.01 * lesion);
        EXPECT_NEAR(volumes[1].by_slices, organ, 0.02 * organ);
    }
}

}  // namespace
}  // namespace anatomesh::nested_field_test
