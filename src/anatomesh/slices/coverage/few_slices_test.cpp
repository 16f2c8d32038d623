// Laws of how thick the slices of structures on few of them are, on random stacks.
#include "anatomesh/slices/coverage/few_slices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/volume.h"

namespace anatomesh::few_slices_test {
namespace {

using namespace fixtures;

std::vector<FewSlices> few_of(const ContourSet& set, double asked_mm = 0) {
    return structures_on_few_slices(set, parallel_intervals(set, set.slices.front().plane), asked_mm);
}

// Discs of structures 0, 1, ... at the heights of each.
ContourSet discs(const std::vector<std::vector<double>>& heights, double radius = 6) {
    std::vector<double> all;
    for (const std::vector<double>& of : heights) all.insert(all.end(), of.begin(), of.end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    SetBuilder builder;
    for (const double z : all) {
        builder.slice(axial(z));
        for (std::uint32_t s = 0; s < heights.size(); ++s)
            if (std::find(heights[s].begin(), heights[s].end(), z) != heights[s].end())
                builder.ring(s, circle({20.0 * s, 0}, radius, 64));
    }
    return builder.set;
}

std::vector<double> every(double spacing, int count) {
    std::vector<double> heights;
    for (int n = 0; n < count; ++n) heights.push_back(n * spacing);
    return heights;
}

TEST(FewSlices, the_user_comes_before_the_source_and_both_before_other_structures) {
    ContourSet set = discs({every(3, 12), {9}});
    ASSERT_EQ(few_of(set).size(), 1u);
    EXPECT_EQ(few_of(set)[0].structure, 1u);
    EXPECT_EQ(few_of(set)[0].mm, 3);
    EXPECT_EQ(few_of(set)[0].by, ThicknessBy::others);
    set.slice_thickness_mm = 3.5;
    EXPECT_EQ(few_of(set)[0].mm, 3.5);
    EXPECT_EQ(few_of(set)[0].by, ThicknessBy::source);
    EXPECT_EQ(few_of(set, 5)[0].mm, 5);
    EXPECT_EQ(few_of(set, 5)[0].by, ThicknessBy::option);
    // The organ is drawn on every second image: the lesion may go on over those between.
    set.slice_thickness_mm = 1.5;
    EXPECT_EQ(few_of(set)[0].mm, 3);
    EXPECT_EQ(few_of(set)[0].by, ThicknessBy::others);
    // A lesion on slices of its own among those of the organ is drawn more finely than this.
    ContourSet finer = discs({every(15, 6), {21}, {33, 36}});
    finer.slice_thickness_mm = 3;
    ASSERT_EQ(few_of(finer).size(), 2u);
    EXPECT_EQ(few_of(finer)[0].mm, 3);
    EXPECT_EQ(few_of(finer)[1].mm, 3);
    finer.slice_thickness_mm = 0;
    EXPECT_EQ(few_of(finer)[0].mm, 15);
    EXPECT_EQ(few_of(finer)[1].mm, 3) << "its own gap";
    // An organ elsewhere says nothing of that, where the source says something.
    ContourSet beyond = discs({every(3, 4), {30}});
    EXPECT_EQ(few_of(beyond)[0].mm, 3);
    beyond.slice_thickness_mm = 1.5;
    EXPECT_EQ(few_of(beyond)[0].mm, 1.5);
}

TEST(FewSlices, nothing_says_it_of_structures_on_few_slices_alone) {
    const ContourSet set = discs({{0}, {15, 40}});
    ASSERT_EQ(few_of(set).size(), 2u);
    for (const FewSlices& few : few_of(set)) {
        EXPECT_EQ(few.mm, 0);
        EXPECT_EQ(few.by, ThicknessBy::nothing);
    }
    EXPECT_EQ(thickness_of_all(set, few_of(set)), 0);
    EXPECT_EQ(thickness_of_all(set, few_of(set, 2)), 2);
    EXPECT_EQ(thickness_of_all(discs({every(3, 3), {3}}), few_of(discs({every(3, 3), {3}}))), 0);
    RunContext context;
    ASSERT_TRUE(make_structure_field(set, {}, context).ok());
    EXPECT_EQ(std::count_if(context.warnings.begin(), context.warnings.end(),
                            [](const Warning& warning) { return warning.code == "W-FLD-021"; }),
              2);
}

TEST(FewSlices, slices_that_say_all_end_a_structure_themselves) {
    ContourSet set = discs({every(3, 12), {9}});
    set.complete = true;
    EXPECT_TRUE(few_of(set, 2).empty());
    EXPECT_TRUE(structures_on_few_slices(set).empty());
    set.complete = false;
    EXPECT_EQ(structures_on_few_slices(set), (std::vector<std::uint32_t>{1}));
}

// Files round the places of slices: one almost on the lesion's plane, which draws the organ alone, does not end it.
TEST(FewSlices, a_slice_as_good_as_on_the_same_plane_says_nothing) {
    for (const double off : {0.0, 0.02, 0.1, 0.3, 1.0, 1.4}) {
        ContourSet set = discs({every(3, 12), {15 + off}});
        RunContext context;
        const auto field = make_structure_field(set, {}, context);
        ASSERT_TRUE(field.ok());
        const auto volumes = field_volumes(*field.value(), 2, {}, context);
        const double disc = 3 * 32 * std::sin(2 * std::numbers::pi / 64) * 36,
                     made = volumes.value()[1].by_field;
        const bool ends_sooner = off > 0.36;  // in the middle of the gap to the slice beside it
        EXPECT_NEAR(made / disc, ends_sooner ? (0.5 * off + 1.5) / 3 : 1, 0.03) << off;
        const auto told = std::find_if(context.warnings.begin(), context.warnings.end(),
                                       [](const Warning& warning) { return warning.code == "W-FLD-021"; });
        ASSERT_NE(told, context.warnings.end());
        EXPECT_EQ(told->what_was_done.starts_with("slices beside it"), ends_sooner) << off;
    }
}

// The organ does not grow because a lesion above it is drawn two spacings on.
TEST(FewSlices, what_is_drawn_beyond_a_structure_does_not_lengthen_it) {
    for (const double beyond : {1.6, 1.9, 2.0, 2.1, 3.0}) {
        RunContext context;
        const ContourSet set = discs({every(2.4, 10), {9 * 2.4 + beyond * 2.4}});
        const auto field = make_structure_field(set, {}, context);
        ASSERT_TRUE(field.ok());
        EXPECT_LT(field.value()->value(0, {0, 0, 9.49 * 2.4}), 0);
        EXPECT_GT(field.value()->value(0, {0, 0, 9.51 * 2.4}), 0) << beyond;
    }
}

// Structures on one slice, on two beside each other and on two far apart, on any slices of a stack.
TEST(FewSlices, volumes_are_those_of_slices_as_thick_as_told) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> between(0, 1);
    for (int n = 0; n < 60; ++n) {
        const double thickness = 1 + 4 * between(random), radius = 4 + 8 * between(random);
        const auto number = [&](int low, int high) {
            return low + static_cast<int>(between(random) * (high - low + 1));
        };
        const auto at = [&](std::initializer_list<int> numbers) {
            std::vector<double> heights;
            for (const int k : numbers) heights.push_back(k * thickness);
            return heights;
        };
        const int first = number(0, 4);
        std::vector<std::vector<double>> heights{at({number(0, 30)}), at({first, first + 1}),
                                                 at({first + 1, first + 1 + number(3, 9)})};
        if (n % 3 == 0) heights.push_back(every(thickness, 40));
        ContourSet set = discs(heights, radius);
        const bool by_option = n % 2 == 0;
        FieldOptions options;
        if (by_option)
            options.single_slice_mm = thickness;
        else
            set.slice_thickness_mm = thickness;
        RunContext context;
        const auto field = make_structure_field(set, options, context);
        ASSERT_TRUE(field.ok());
        const auto volumes =
            field_volumes(*field.value(), static_cast<std::uint32_t>(heights.size()), {}, context);
        ASSERT_TRUE(volumes.ok());
        const double disc = thickness * 32 * std::sin(2 * std::numbers::pi / 64) * radius * radius;
        EXPECT_NEAR(volumes.value()[0].by_field / disc, 1, 0.03) << n;
        EXPECT_NEAR(volumes.value()[1].by_field / disc, 2, 0.06) << n;
        EXPECT_NEAR(volumes.value()[2].by_field / disc, 2, 0.06) << n;
    }
}

}  // namespace
}  // namespace anatomesh::few_slices_test
