#include "anatomesh/live/section/section_of_field.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/random_drawing_for_test.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::section_of_field_test {
namespace {

using namespace fixtures;

double area_of_rings(const StructureRings& drawn) {
    double area = 0;
    for (const auto& ring : drawn.rings) area += signed_area(ring.at);
    return area;
}

Proposal proposed(const ContourSet& set, const Plane& plane) {
    RunContext context;
    auto proposal = propose_rings(set, 0, plane, {}, {}, context);
    EXPECT_TRUE(proposal.ok()) << to_line(proposal.error());
    EXPECT_TRUE(check_structure_rings(proposal.value().rings).ok());
    return proposal.value();
}

// However the slices and the plane lie: sound rings whose inside is where the field is negative.
TEST(SectionOfField, holds_what_is_inside_on_random_planes) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(-1, 1);
    int inside = 0, outside = 0, wrong = 0;
    for (int member = 0; member < 40; ++member) {
        const ContourSet set = set_of(random_drawing(static_cast<Lie>(member % 5), member % 4 == 3, random));
        RunContext context;
        context.threads = 1 + member % 2;
        const auto field = make_structure_field(set, {}, context);
        ASSERT_TRUE(field.ok());
        const Box3 box = field.value()->box();
        const Plane plane =
            make_plane(0.5 * (box.low + box.high), {unit(random), unit(random), unit(random) + 0.1});
        const SectionOptions options;
        const auto section = section_of_field(*field.value(), 0, plane, options, context);
        ASSERT_TRUE(section.ok()) << to_line(section.error());
        ASSERT_TRUE(check_structure_rings(section.value()).ok());
        for (int n = 0; n < 500; ++n) {
            const Vec2 q{15 * unit(random), 15 * unit(random)};
            const double value = field.value()->value(0, plane.to_space(q));
            if (std::abs(value) < options.step_mm) continue;
            wrong += lies_in(section.value(), q) != (value < 0);
            ++(value < 0 ? inside : outside);
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(outside, 1000);
    EXPECT_LT(wrong, (inside + outside) / 500);  // parts thinner than a step
}

TEST(SectionOfField, of_a_ball_has_the_area_of_its_circle) {
    const ContourSet set = ball(20, -20, 2, 180);
    RunContext context;
    const auto field = make_structure_field(set, {}, context);
    ASSERT_TRUE(field.ok());
    for (const double z : {-13.0, -5.0, 1.0, 7.0}) {
        for (const Vec3 normal : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{1, 2, 2}}) {
            const Plane plane = make_plane((z / length(normal)) * normal, normal);
            const auto section = section_of_field(*field.value(), 0, plane, {}, context);
            ASSERT_TRUE(section.ok());
            ASSERT_EQ(section.value().rings.size(), 1u);
            EXPECT_NEAR(area_of_rings(section.value()), M_PI * (400 - z * z), 0.02 * M_PI * (400 - z * z));
        }
    }
    const auto beside = section_of_field(*field.value(), 0, axial(30), {}, context);
    ASSERT_TRUE(beside.ok());
    EXPECT_TRUE(beside.value().rings.empty());
}

// Two circles six images apart.
TEST(ProposeRings, radii_go_from_one_slice_to_the_other) {
    SetBuilder builder;
    builder.slice(axial(30));
    builder.ring(0, circle({}, 10, 90));
    builder.slice(axial(48));
    builder.ring(0, circle({}, 20, 90));
    for (int k = 11; k <= 15; ++k) {
        const Proposal proposal = proposed(builder.set, axial(3.0 * k));
        ASSERT_EQ(proposal.reason, NothingProposed::none) << k;
        ASSERT_EQ(proposal.rings.rings.size(), 1u);
        for (const Vec2 q : proposal.rings.rings[0].at)
            EXPECT_NEAR(length(q), 10 + 10 * (k - 10) / 6.0, 0.5) << k;
    }
}

// An ellipse becomes two discs once.
TEST(ProposeRings, a_branch_parts_once) {
    SetBuilder builder;
    builder.slice(axial(30));
    fixtures::Ring ellipse = circle({}, 1, 120);
    for (Vec2& q : ellipse) q = {30 * q.x, 10 * q.y};
    builder.ring(0, ellipse);
    builder.slice(axial(48));
    builder.ring(0, circle({-20, 0}, 10, 60));
    builder.ring(0, circle({20, 0}, 10, 60));
    std::size_t before = 1;
    for (int k = 11; k <= 15; ++k) {
        const Proposal proposal = proposed(builder.set, axial(3.0 * k));
        ASSERT_EQ(proposal.reason, NothingProposed::none);
        EXPECT_GE(proposal.rings.rings.size(), before);
        EXPECT_LE(proposal.rings.rings.size(), 2u);
        EXPECT_GT(area_of_rings(proposal.rings), 565);
        EXPECT_LT(area_of_rings(proposal.rings), 1037);
        before = proposal.rings.rings.size();
    }
    EXPECT_EQ(before, 2u);
}

TEST(ProposeRings, holes_stay_holes) {
    SetBuilder builder;
    for (const double z : {30.0, 48.0}) {
        builder.slice(axial(z));
        builder.ring(0, circle({}, 30, 120));
        builder.ring(0, reversed(circle({}, 12, 60)));
    }
    for (int k = 11; k <= 15; ++k) {
        const Proposal proposal = proposed(builder.set, axial(3.0 * k));
        EXPECT_EQ(proposal.rings.rings.size(), 2u);
        EXPECT_NEAR(area_of_rings(proposal.rings), 2375, 0.02 * 2375);
    }
}

TEST(ProposeRings, says_why_there_is_nothing) {
    SetBuilder builder;
    builder.slice(axial(30));
    builder.ring(0, circle({}, 10, 90));
    EXPECT_EQ(proposed(builder.set, axial(33)).reason, NothingProposed::one_slice);
    EXPECT_EQ(proposed(builder.set, axial(30)).reason, NothingProposed::drawn_here);
    builder.slice(axial(33));
    builder.ring(0, circle({}, 10, 90));
    EXPECT_EQ(proposed(builder.set, axial(33)).reason, NothingProposed::drawn_here);
    EXPECT_EQ(proposed(builder.set, axial(36)).reason, NothingProposed::beyond_ends);
    EXPECT_EQ(proposed(builder.set, axial(27)).reason, NothingProposed::beyond_ends);
    EXPECT_EQ(proposed(builder.set, make_plane({50, 0, 0}, {1, 0, 0})).reason, NothingProposed::nothing_here);
    EXPECT_EQ(proposed(builder.set, make_plane({5, 0, 0}, {1, 0, 0})).reason, NothingProposed::none);
}

TEST(SectionOfField, larger_than_allowed_is_refused_and_ends_when_cancelled) {
    const ContourSet set = ball(20, -20, 2, 90);
    RunContext context;
    const auto field = make_structure_field(set, {}, context);
    ASSERT_TRUE(field.ok());
    SectionOptions options;
    options.max_points = 1000;
    EXPECT_EQ(section_of_field(*field.value(), 0, axial(1), options, context).error().code, "E-LIV-301");
    const std::atomic<bool> cancel = true;
    context.cancel = &cancel;
    EXPECT_EQ(section_of_field(*field.value(), 0, axial(1), {}, context).error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace anatomesh::section_of_field_test
