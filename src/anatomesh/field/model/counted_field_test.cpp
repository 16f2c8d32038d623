#include "anatomesh/field/model/counted_field.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"

namespace anatomesh::counted_field_test {
namespace {

using namespace fixtures;

bool same(const std::vector<StructureField::Near>& a, const std::vector<StructureField::Near>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
        return x.structure == y.structure && x.value == y.value;
    });
}

TEST(CountedField, answers_as_the_field_does_and_counts_each_place) {
    RunContext context;
    const auto made = make_structure_field(ball(20, -19, 2, 60), {}, context);
    ASSERT_TRUE(made.ok());
    const StructureField& field = *made.value();
    const CountedField counted(made.value());
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-25, 25);
    std::uint64_t asked = 0;
    std::vector<std::uint32_t> members, members_counted;
    for (int n = 0; n < 200; ++n) {
        const Vec3 p{place(random), place(random), place(random)};
        EXPECT_EQ(counted.value(0, p), field.value(0, p));
        EXPECT_EQ(counted.value_within(0, p, 1), field.value_within(0, p, 1));
        EXPECT_EQ(counted.interface_distance(p), field.interface_distance(p));
        EXPECT_EQ(counted.union_value(p), field.union_value(p));
        std::vector<StructureField::Near> near, near_counted;
        field.values_near(p, near);
        counted.values_near(p, near_counted);
        EXPECT_TRUE(same(near, near_counted));
        field.members(p, members);
        counted.members(p, members_counted);
        EXPECT_EQ(members, members_counted);
        EXPECT_EQ(counted.members_and_distance(p, members_counted), field.members_and_distance(p, members));
        EXPECT_EQ(members, members_counted);
        EXPECT_EQ(counted.slices_may_differ(p, 1), field.slices_may_differ(p, 1));
        asked += 7;  // but for the last, which asks for no value
        EXPECT_EQ(counted.values(), asked);
    }
    EXPECT_EQ(counted.clamp(), field.clamp());
    EXPECT_EQ(counted.slice_spacing(), field.slice_spacing());
    EXPECT_EQ(counted.box().low, field.box().low);
    EXPECT_EQ(counted.box_of(0).high, field.box_of(0).high);
    EXPECT_EQ(counted.exclusive(), field.exclusive());
    EXPECT_EQ(counted.values(), asked);
}

}  // namespace
}  // namespace anatomesh::counted_field_test
