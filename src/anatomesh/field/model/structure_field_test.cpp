#include "anatomesh/field/model/structure_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"

namespace anatomesh::structure_field_test {
namespace {

using namespace fixtures;
using FieldPointer = std::shared_ptr<const StructureField>;

FieldPointer field_of(const ContourSet& set, const FieldOptions& options = {}) {
    RunContext context;
    auto field = make_structure_field(set, options, context);
    EXPECT_TRUE(field.ok()) << (field.ok() ? "" : to_line(field.error()));
    return field.ok() ? field.value() : nullptr;
}

Vec3 random_point(const Box3& box, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(0, 1);
    return {box.low.x + unit(random) * (box.high.x - box.low.x),
            box.low.y + unit(random) * (box.high.y - box.low.y),
            box.low.z + unit(random) * (box.high.z - box.low.z)};
}

// Moves a set: rotation about an oblique axis, then a shift.
struct Motion {
    Vec3 u = normalized({2, 1, -0.5}), v = normalized(cross(Vec3{0.3, -1, 2}, u)), w = cross(u, v),
         shift{100, -50, 7};
    Vec3 turn(Vec3 p) const { return p.x * u + p.y * v + p.z * w; }
    Vec3 operator()(Vec3 p) const { return turn(p) + shift; }
    ContourSet operator()(ContourSet set) const {
        for (Vec3& p : set.points) p = (*this)(p);
        for (Slice& s : set.slices) {
            s.plane = {(*this)(s.plane.origin), turn(s.plane.u), turn(s.plane.v), turn(s.plane.normal)};
        }
        return set;
    }
};

// Two structures that share a wall which wanders from slice to slice, one of them with a hole; uneven
// spacing.
ContourSet touching_pair() {
    SetBuilder builder(true);
    const double z[] = {0, 3, 5, 9, 12};
    for (int k = 0; k < 5; ++k) {
        builder.slice(axial(z[k]));
        const double wall = 2.0 * k;
        builder.ring(0, {{-20, -10}, {wall, -10}, {wall + 3, 0}, {wall, 10}, {-20, 10}});
        builder.ring(0, reversed(circle({-10, 0}, 4, 20)));
        if (k < 4) builder.ring(1, {{wall, -10}, {25, -10}, {25, 10}, {wall, 10}, {wall + 3, 0}});
    }
    return builder.set;
}

TEST(StructureField, zero_exactly_at_every_contour_vertex) {
    const std::vector<ContourSet> sets{ball(20, -19, 3, 61), touching_pair(), Motion{}(ball(20, -19, 3, 61)),
                                       Motion{}(touching_pair())};
    for (const ContourSet& set : sets) {
        const FieldPointer field = field_of(set);
        for (const Contour& contour : set.contours) {
            for (const Vec3& p : set.points_of(contour)) {
                ASSERT_EQ(field->value(contour.structure, p), 0.0);
                ASSERT_EQ(field->interface_distance(p), 0.0);
            }
        }
    }
}

TEST(StructureField, sign_on_a_slice_is_the_drawn_region) {
    std::mt19937 random(4);
    SetBuilder builder;
    std::vector<std::vector<Edge2>> drawn;
    for (int k = 0; k < 6; ++k) {
        builder.slice(axial(2.5 * k));
        const std::vector<Ring> rings{star({0, 0}, 8, 20, 50, random),
                                      reversed(star({0, 0}, 2, 7, 15, random))};
        for (const Ring& ring : rings) builder.ring(0, ring);
        drawn.push_back(edges_of(rings));
    }
    const FieldPointer field = field_of(builder.set);
    std::uniform_real_distribution<double> at(-22, 22);
    for (std::size_t k = 0; k < drawn.size(); ++k) {
        for (int i = 0; i < 2000; ++i) {
            const Vec2 q{at(random), at(random)};
            bool inside = false;
            for (const Edge2& e : drawn[k]) {
                if ((e.a.y <= q.y) == (e.b.y <= q.y)) continue;
                const double x = e.a.x + (q.y - e.a.y) / (e.b.y - e.a.y) * (e.b.x - e.a.x);
                inside ^= x > q.x;
            }
            ASSERT_EQ(field->value(0, {q.x, q.y, 2.5 * static_cast<double>(k)}) < 0, inside);
        }
    }
}

TEST(StructureField, C10_exclusive_structures_leave_no_gap_and_no_overlap) {
    const ContourSet set = touching_pair();
    const FieldPointer field = field_of(set);
    std::mt19937 random(8);
    std::vector<std::uint32_t> members;
    std::vector<StructureField::Near> near;
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = random_point(field->box(), random);
        field->members(p, members);
        ASSERT_LE(members.size(), 1u);
        near.clear();
        field->values_near(p, near);
        double smallest = 1e9;
        for (const auto& [structure, value] : near) {
            ASSERT_EQ(value, field->value(structure, p));
            ASSERT_EQ(value < 0, !members.empty() && members[0] == structure);
            smallest = std::min(smallest, std::abs(value));
        }
        ASSERT_EQ(field->interface_distance(p), std::min(smallest, field->clamp()));
        // Between the first and the fourth slice both are drawn and fill the outer rectangle but for the
        // hole.
        const bool in_block = p.z > 0 && p.z < 9 && p.x > -20 && p.x < 25 && std::abs(p.y) < 10;
        const bool in_hole = std::hypot(p.x + 10, p.y) < 4.1;
        if (in_block && !in_hole) {
            ASSERT_EQ(members.size(), 1u) << p.x << " " << p.y << " " << p.z;
            ++inside;
        }
    }
    EXPECT_GT(inside, 5000);
}

// Structures that begin and end on different slices inside, beside and above one another: every query tells
// the same.
TEST(StructureField, exclusive_queries_agree_where_structures_end) {
    SetBuilder builder(true);
    for (int k = 0; k < 6; ++k) {
        builder.slice(axial(3 * k));
        const Ring organ = circle({}, 12, 60), first = circle({-5, 0}, 3, 30), second = circle({4, 1}, 4, 30);
        builder.ring(0, organ);
        if (k == 2) {
            builder.ring(0, reversed(first));
            builder.ring(1, first);
        }
        if (k == 2 || k == 3) builder.ring(0, reversed(second));
        if (k == 2) builder.ring(2, second);
        if (k == 3) builder.ring(3, second);
    }
    const FieldPointer field = field_of(builder.set);
    std::mt19937 random(9);
    std::vector<std::uint32_t> members, again;
    std::vector<StructureField::Near> near;
    std::vector<int> owned(4);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 p = random_point(field->box(), random);
        field->members(p, members);
        ASSERT_LE(members.size(), 1u);
        near.clear();
        field->values_near(p, near);
        double smallest = field->clamp();
        for (const auto& [structure, value] : near) {
            ASSERT_EQ(value, field->value(structure, p));
            ASSERT_EQ(value < 0, !members.empty() && members[0] == structure);
            smallest = std::min(smallest, std::abs(value));
        }
        ASSERT_EQ(field->interface_distance(p), smallest);
        ASSERT_EQ(field->members_and_distance(p, again), smallest);
        ASSERT_EQ(again, members);
        if (!members.empty()) ++owned[members[0]];
    }
    for (const int count : owned) EXPECT_GT(count, 50);
}

// The side alone is what members() asks for: the same as the sign of the value, on slices and between them.
void expect_members_by_sign(const ContourSet& set) {
    const FieldPointer field = field_of(set);
    std::mt19937 random(10);
    std::vector<std::uint32_t> members;
    int inside = 0, outside = 0;
    for (int i = 0; i < 20000; ++i) {
        Vec3 p = random_point(field->box(), random);
        if (i % 2) p.z = set.slices[random() % set.slices.size()].plane.origin.z;
        field->members(p, members);
        for (std::uint32_t s = 0; s < set.structures.size(); ++s)
            ASSERT_EQ(field->value(s, p) < 0, std::count(members.begin(), members.end(), s) == 1);
        ++(members.empty() ? outside : inside);
    }
    EXPECT_GT(inside, 2000);
    EXPECT_GT(outside, 2000);
}

TEST(StructureField, members_are_the_structures_with_negative_values) {
    expect_members_by_sign(touching_pair());
    SetBuilder overlapping;
    for (int k = 0; k < 5; ++k) {
        overlapping.slice(axial(3 * k));
        overlapping.ring(0, circle({}, 10 - k, 40));
        overlapping.ring(1, circle({2.0 * k, 0}, 5, 40));
        if (k != 2) overlapping.ring(2, circle({-4, 1}, 3 + 0.5 * k, 40));
    }
    expect_members_by_sign(overlapping.set);
}

// On the wall itself the lowest index owns the point, so that no cell centre falls into a crack.
TEST(StructureField, exclusive_tie_goes_to_the_lower_index) {
    SetBuilder builder(true);
    for (const double z : {0.0, 4.0}) {
        builder.slice(axial(z));
        builder.ring(z == 0 ? 1 : 0, {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}});
    }
    const FieldPointer field = field_of(builder.set);
    std::vector<std::uint32_t> members;
    field->members({0, 0, 2}, members);
    ASSERT_EQ(members, std::vector<std::uint32_t>{0});
    EXPECT_EQ(field->value(0, {0, 0, 2}), 0.0);
    EXPECT_EQ(field->interface_distance({0, 0, 2}), 0.0);
}

TEST(StructureField, overlapping_structures_are_both_members) {
    SetBuilder builder;
    for (const double z : {0.0, 3.0, 6.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 10, 40));
        builder.ring(1, circle({}, 5, 40));
        builder.ring(2, circle({4, 0}, 5, 40));
    }
    const FieldPointer field = field_of(builder.set);
    std::vector<std::uint32_t> members;
    field->members({3, 0, 4}, members);
    EXPECT_EQ(members, (std::vector<std::uint32_t>{0, 1, 2}));
    field->members({8, 0, 4}, members);
    EXPECT_EQ(members, (std::vector<std::uint32_t>{0, 2}));
    field->members({0, 11, 4}, members);
    EXPECT_TRUE(members.empty());
}

TEST(StructureField, tilted_and_moved_stack_equals_the_axial_one) {
    for (const ContourSet& set : {ball(15, -14, 2.5, 37), touching_pair()}) {
        ContourSet mirrored = Motion{}(set);  // as a source with the opposite normal would give it
        for (Slice& s : mirrored.slices) s.plane = {s.plane.origin, s.plane.v, s.plane.u, -s.plane.normal};
        std::reverse(mirrored.slices.begin(), mirrored.slices.end());
        const FieldPointer axial_field = field_of(set), moved = field_of(Motion{}(set)),
                           other = field_of(mirrored);
        std::mt19937 random(6);
        for (int i = 0; i < 5000; ++i) {
            const Vec3 p = random_point(axial_field->box().grown(1), random);
            for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
                const double expected = axial_field->value(s, p);
                ASSERT_NEAR(moved->value(s, Motion{}(p)), expected, 1e-3);
                // Rounding may decide between two equally good matches: the same but for a thin layer.
                if (std::abs(expected) > 0.2) {
                    ASSERT_EQ(other->value(s, Motion{}(p)) < 0, expected < 0)
                        << p.x << " " << p.y << " " << p.z;
                }
            }
        }
    }
}

TEST(StructureField, half_caps_end_half_a_slice_beyond_flat_caps_at_the_contour) {
    SetBuilder builder;
    for (const double z : {0.0, 3.0, 6.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 10, 40));
    }
    const FieldPointer half = field_of(builder.set);
    FieldOptions options;
    options.caps = EndCaps::flat;
    const FieldPointer flat = field_of(builder.set, options);
    EXPECT_LT(half->value(0, {0, 0, 7.499}), 0);
    EXPECT_GT(half->value(0, {0, 0, 7.501}), 0);
    EXPECT_LT(half->value(0, {0, 0, -1.499}), 0);
    EXPECT_GT(half->value(0, {0, 0, -1.501}), 0);
    EXPECT_LT(flat->value(0, {0, 0, 5.999}), 0);
    EXPECT_EQ(flat->value(0, {0, 0, 6}), 0.0);
    EXPECT_GT(flat->value(0, {0, 0, 6.001}), 0);
    EXPECT_GT(flat->value(0, {0, 0, -0.001}), 0);
}

TEST(StructureField, C19_rounded_caps_are_half_caps_with_a_quarter_circle_along_the_rim) {
    SetBuilder builder;
    for (const double z : {0.0, 3.0, 6.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 10, 400));
    }
    FieldOptions options;
    options.caps = EndCaps::rounded;
    const FieldPointer field = field_of(builder.set, options);
    EXPECT_EQ(field->value(0, builder.set.points.front()), 0.0);
    for (const double h : {0.1, 0.5, 1.0, 1.4}) {
        const double reach = 10 - 1.5 + std::sqrt(1.5 * 1.5 - h * h);
        for (const double z : {6 + h, -h}) {
            EXPECT_LT(field->value(0, {reach - 0.01, 0, z}), 0) << h;
            EXPECT_GT(field->value(0, {reach + 0.01, 0, z}), 0) << h;
        }
    }
    EXPECT_LT(field->value(0, {0, 0, 7.499}), 0);
    EXPECT_GT(field->value(0, {0, 0, 7.501}), 0);
    // Continuous from the slice to a spacing beyond it.
    for (double z = 6; z < 8.98; z += 0.01) {
        for (const double x : {0.0, 8.0, 8.6, 9.9, 10.5, 13.0})
            EXPECT_NEAR(field->value(0, {x, 0, z}), field->value(0, {x, 0, z + 0.01}), 0.06) << x << " " << z;
    }
}

TEST(StructureField, flat_caps_leave_half_to_an_island_on_one_slice_and_say_so) {
    SetBuilder builder;
    for (const double z : {0.0, 3.0, 6.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 10, 40));
        if (z == 3) builder.ring(1, circle({30, 0}, 4, 20));
    }
    FieldOptions options;
    options.caps = EndCaps::flat;
    RunContext context;
    const auto field = make_structure_field(builder.set, options, context);
    ASSERT_TRUE(field.ok());
    ASSERT_EQ(context.warnings.size(), 2u);
    EXPECT_EQ(context.warnings[0].code, "W-FLD-004");
    EXPECT_EQ(context.warnings[1].code, "W-FLD-021") << "how thick it is, is a guess";
    for (const Warning& warning : context.warnings) EXPECT_EQ(warning.place.structure, "S2");
    EXPECT_LT(field.value()->value(1, {30, 0, 4.49}), 0);
    EXPECT_GT(field.value()->value(1, {30, 0, 4.51}), 0);
}

ContourSet cylinder_without(int first_missing, int count) {
    SetBuilder builder;
    for (int k = 0; k < 40; ++k) {
        if (k >= first_missing && k < first_missing + count) continue;
        builder.slice(axial(3.0 * k));
        builder.ring(0, circle({}, 10, 40));
    }
    return builder.set;
}

TEST(StructureField, RS18_one_missing_slice_is_bridged_five_and_twenty_are_not) {
    for (const int missing : {1, 5, 20}) {
        RunContext context;
        const auto field = make_structure_field(cylinder_without(10, missing), {}, context);
        ASSERT_TRUE(field.ok());
        const double last = 27, next = 3.0 * (10 + missing), middle = 0.5 * (last + next);
        ASSERT_EQ(context.warnings.size(), 1u);
        EXPECT_EQ(context.warnings[0].code, missing == 1 ? "W-FLD-002" : "W-FLD-001");
        EXPECT_EQ(context.warnings[0].place.slice, "slice 9 and slice 10");
        if (missing == 1) {
            EXPECT_LT(field.value()->value(0, {0, 0, middle}), 0);
            continue;
        }
        EXPECT_GT(field.value()->value(0, {0, 0, middle}), 0);
        EXPECT_LT(field.value()->value(0, {0, 0, last + 1.49}), 0);
        EXPECT_GT(field.value()->value(0, {0, 0, last + 1.51}), 0);
        EXPECT_LT(field.value()->value(0, {0, 0, next - 1.49}), 0);
        EXPECT_GT(field.value()->value(0, {0, 0, next - 1.51}), 0);
    }
}

TEST(StructureField, RS18_a_slice_with_other_structures_alone_is_empty) {
    SetBuilder builder;
    for (int k = 0; k < 9; ++k) {
        builder.slice(axial(3.0 * k));
        builder.ring(0, circle({}, 20, 40));
        if (k != 4) builder.ring(1, circle({}, 10, 40));
    }
    RunContext context;
    const auto field = make_structure_field(builder.set, {}, context);
    ASSERT_TRUE(field.ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-FLD-003");
    EXPECT_GT(field.value()->value(1, {0, 0, 12}), 0);
    EXPECT_LT(field.value()->value(1, {0, 0, 9}), 0);
}

TEST(StructureField, a_slice_without_any_contour_is_empty) {
    SetBuilder builder;
    for (int k = 0; k < 9; ++k) {
        builder.slice(axial(3.0 * k));
        if (k != 4) builder.ring(0, circle({}, 10, 40));
    }
    RunContext context;
    const auto field = make_structure_field(builder.set, {}, context);
    ASSERT_TRUE(field.ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-FLD-003");
    EXPECT_GT(field.value()->value(0, {0, 0, 12}), 0);
    EXPECT_LT(field.value()->value(0, {0, 0, 9}), 0);
    EXPECT_LT(field.value()->value(0, {0, 0, 15}), 0);
}

TEST(StructureField, RS19_a_structure_on_every_fifth_slice_is_joined_at_its_own_spacing) {
    SetBuilder builder;
    for (int k = 0; k < 31; ++k) {
        builder.slice(axial(3.0 * k));
        builder.ring(0, circle({}, 20, 40));
        if (k % 5 == 0) builder.ring(1, circle({}, 10, 40));
    }
    RunContext context;
    const auto field = make_structure_field(builder.set, {}, context);
    ASSERT_TRUE(field.ok());
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_EQ(context.warnings[0].code, "W-FLD-012") << "a guess, told";
    EXPECT_EQ(context.warnings[0].place.structure, "S2");
    for (double z = -7; z < 97; z += 1) EXPECT_LT(field.value()->value(1, {0, 0, z}), 0) << z;
    EXPECT_GT(field.value()->value(1, {0, 0, 98}), 0);
}

TEST(StructureField, says_what_it_cannot_make) {
    RunContext context;
    const auto none = make_structure_field(ContourSet{}, {}, context);
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, "E-FLD-001");
    SetBuilder one;
    one.slice(axial(5));
    one.ring(0, circle({}, 10, 40));
    const auto refused = make_structure_field(one.set, {}, context);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-FLD-003");
    FieldOptions options;
    ContourSet stated = one.set;
    stated.slice_thickness_mm = 4;
    EXPECT_TRUE(make_structure_field(stated, {}, context).ok()) << "the source says how thick a slice is";
    options.single_slice_mm = 4;
    const FieldPointer field = field_of(one.set, options);
    EXPECT_LT(field->value(0, {0, 0, 6.9}), 0);
    EXPECT_GT(field->value(0, {0, 0, 7.1}), 0);
}

TEST(StructureField, box_holds_every_point_inside) {
    for (const ContourSet& set : {ball(15, -14, 2.5, 37), Motion{}(touching_pair())}) {
        const FieldPointer field = field_of(set);
        std::mt19937 random(3);
        std::vector<std::uint32_t> members;
        for (int i = 0; i < 20000; ++i) {
            const Vec3 p = random_point(field->box().grown(10), random);
            field->members(p, members);
            ASSERT_TRUE(members.empty() || field->box().contains(p));
        }
    }
}

}  // namespace
}  // namespace anatomesh::structure_field_test
