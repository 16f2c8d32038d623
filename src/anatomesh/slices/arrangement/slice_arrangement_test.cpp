// Laws of how slices lie: every arrangement is found by its kind, and no rigid movement or order changes it.
#include "anatomesh/slices/arrangement/slice_arrangement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/field/rotational_fixtures_for_test.h"

namespace anatomesh::slice_arrangement_test {
namespace {

using namespace fixtures;

struct Case {
    const char* name;
    ArrangementKind kind;
    std::vector<Plane> planes;
};

// Slices 5 mm apart, of which each leans by so much more than the one before, in radians.
std::vector<Plane> leaning(double by) {
    std::vector<Plane> planes;
    for (int k = -4; k <= 4; ++k) planes.push_back(make_plane({0, 0, 5.0 * k}, {by * k, 0, 1}));
    return planes;
}

std::vector<Case> cases() {
    std::vector<Plane> crossed = leaning(0), general;
    crossed.push_back(make_plane({}, {1, 0, 0}));
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{1, 1, 0}, Vec3{0, 1, 1}})
        general.push_back(make_plane({1, 2, 3}, normal));
    return {{"single", ArrangementKind::parallel, {make_plane({}, {0, 0, 1})}},
            {"parallel", ArrangementKind::parallel, leaning(0)},
            {"sweep", ArrangementKind::sweep, leaning(0.02)},
            {"about an axis", ArrangementKind::about_axis, planes_about(make_plane({}, {0, 0, 1}), 12)},
            {"crossed", ArrangementKind::stack_and_crossing, crossed},
            {"general", ArrangementKind::general, general}};
}

// About the first axis by 40 degrees, then away.
Plane moved(const Plane& plane) {
    const auto turned = [](Vec3 v) {
        return Vec3{v.x, 0.766 * v.y - 0.643 * v.z, 0.643 * v.y + 0.766 * v.z};
    };
    return make_plane(turned(plane.origin) + Vec3{300, -20, 7}, turned(plane.normal));
}

TEST(SliceArrangement, is_found_by_its_kind_wherever_and_in_whatever_order_the_slices_are) {
    std::mt19937 random(8);
    for (const Case& given : cases()) {
        SCOPED_TRACE(given.name);
        std::vector<Plane> elsewhere;
        for (const Plane& plane : given.planes) elsewhere.push_back(moved(plane));
        const ContourSet here = sections_of({{}, {25, 22, 38}}, in_any_order(given.planes, random), 60),
                         there = sections_of({{300, -20, 7}, {25, 25, 25}}, elsewhere, 60);
        EXPECT_EQ(arrangement_of(here).kind, given.kind);
        EXPECT_EQ(arrangement_of(there).kind, given.kind);
    }
}

TEST(SliceArrangement, has_the_charts_of_its_kind) {
    for (const Case& given : cases()) {
        SCOPED_TRACE(given.name);
        const SliceArrangement found = arrangement_of(sections_of({{}, {25, 22, 38}}, given.planes, 60));
        EXPECT_EQ(found.sweep.has_value(), given.kind == ArrangementKind::sweep);
        EXPECT_EQ(found.is_parallel(), given.kind == ArrangementKind::parallel);
        EXPECT_EQ(found.is_stack(), found.is_parallel() || found.sweep.has_value());
        if (given.kind == ArrangementKind::about_axis) {
            EXPECT_TRUE(found.rotation);
            EXPECT_NEAR(std::abs(found.axis.direction.z), 1, 1e-9);
        }
        if (given.kind == ArrangementKind::stack_and_crossing) {
            ASSERT_TRUE(found.parts);
            EXPECT_EQ(found.parts->crossing, std::vector<std::uint32_t>{9});
        }
        if (found.is_parallel()) {
            EXPECT_FALSE(found.rotation || found.parts);
        }
    }
}

// The stack of a set with slices across it is a set of its own.
TEST(SliceArrangement, of_chosen_slices_is_that_of_these) {
    for (const Case& given : cases()) {
        if (given.kind != ArrangementKind::stack_and_crossing) continue;
        const ContourSet set = sections_of({{}, {25, 22, 38}}, given.planes, 60);
        const ContourSet stack = chosen_slices(set, arrangement_of(set).parts->stack);
        EXPECT_TRUE(arrangement_of(stack).is_parallel());
    }
}

TEST(SliceArrangement, a_wider_gap_about_an_axis_changes_no_kind) {
    std::vector<Plane> planes = planes_about(make_plane({}, {0, 0, 1}), 16);
    planes.erase(planes.begin() + 3, planes.begin() + 7);
    const ContourSet set = sections_of({{}, {25, 22, 38}}, planes, 60);
    for (const double gap : {1.0, 2.0, 8.0})
        EXPECT_EQ(arrangement_of(set, gap).kind, ArrangementKind::about_axis) << gap;
}

TEST(SliceArrangement, of_nothing_is_parallel_and_of_empty_slices_their_kind_alone) {
    EXPECT_TRUE(arrangement_of({}).is_parallel());
    ContourSet empty;
    empty.slices = {{make_plane({}, {0, 0, 1}), 0, 0, "a"}, {make_plane({}, {0, 1, 0}), 0, 0, "b"}};
    const SliceArrangement found = arrangement_of(empty);
    EXPECT_FALSE(found.sweep || found.rotation || found.parts);
}

}  // namespace
}  // namespace anatomesh::slice_arrangement_test
