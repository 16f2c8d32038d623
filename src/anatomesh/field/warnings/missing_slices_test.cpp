#include "anatomesh/field/warnings/missing_slices.h"

#include <gtest/gtest.h>

#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/rotational_fixtures_for_test.h"

namespace anatomesh::missing_slices_test {
namespace {

using namespace fixtures;

void warn_about_gaps_of(const ContourSet& set, RunContext& context) {
    warn_about_missing_slices(set, rotation_axis(set), context);
}

// Slices 3 mm apart that lean by up to so many radians, without some from the 8th on.
ContourSet held_by_hand(double most_lean, std::size_t missing, std::mt19937& random) {
    std::vector<Plane> planes;
    for (int k = -12; k <= 12; ++k) planes.push_back(make_plane({0, 0, 3.0 * k}, {0, 0, 1}));
    planes = beside_their_places(std::move(planes), 0.5, most_lean, random);
    planes.erase(planes.begin() + 8, planes.begin() + 8 + static_cast<std::ptrdiff_t>(missing));
    return sections_of({{}, {25, 22, 38}}, planes, 60);
}

TEST(MissingSlices, RS18_are_told_of_between_slices_that_cross) {
    std::mt19937 random(3);
    for (const double lean : {0.1, 0.25}) {
        for (const std::size_t missing : {0u, 1u, 2u, 5u}) {
            RunContext context;
            warn_about_gaps_of(held_by_hand(lean, missing, random), context);
            ASSERT_EQ(context.warnings.size(), missing >= 2) << lean << " " << missing;
            if (missing < 2) continue;
            EXPECT_EQ(context.warnings[0].code, "W-FLD-001");
            EXPECT_NE(context.warnings[0].place.value.find(" mm, between it and slice "), std::string::npos);
        }
    }
}

TEST(MissingSlices, are_none_between_two_passes) {
    std::vector<Plane> planes;
    for (int k = -9; k <= 9; ++k) {
        planes.push_back(make_plane({0, 0, 4.0 * k}, {0.05, 0, 1}));
        planes.push_back(make_plane({0, 0, 4.0 * k + 1}, {-0.08, 0.04, 1}));
    }
    RunContext context;
    warn_about_gaps_of(sections_of({{}, {25, 22, 38}}, planes, 60), context);
    EXPECT_TRUE(context.warnings.empty());
}

TEST(MissingSlices, are_not_looked_for_where_planes_are_turned_or_few) {
    RunContext context;
    warn_about_gaps_of(sections_of({{}, {25, 22, 38}}, planes_about(make_plane({}, {0, 0, 1}), 12), 60),
                       context);
    const std::vector<Plane> few{make_plane({0, 0, 0}, {0, 0, 1}), make_plane({0, 0, 1}, {0, 0.1, 1}),
                                 make_plane({0, 0, 20}, {0, 0, 1})};
    warn_about_gaps_of(sections_of({{}, {25, 22, 38}}, few, 60), context);
    EXPECT_TRUE(context.warnings.empty());
}

TEST(MissingSlices, are_told_of_where_a_turn_was_not_finished) {
    const std::vector<Plane> all = planes_about(make_plane({1, 2, 0}, {0.1, 0, 1}), 30);
    for (const std::ptrdiff_t turned : {6, 15, 24, 30}) {
        RunContext context;
        warn_about_gaps_of(sections_of({{}, {25, 22, 38}}, {all.begin(), all.begin() + turned}, 60), context);
        ASSERT_EQ(context.warnings.size(), turned < 30) << turned;
        if (turned == 30) continue;
        EXPECT_EQ(context.warnings[0].place.value.find(std::to_string(6 * (31 - turned)) + " degrees"), 0u);
    }
}

TEST(MissingSlices, are_told_of_by_the_field) {
    std::mt19937 random(4);
    RunContext context;
    ASSERT_TRUE(make_structure_field(held_by_hand(0.25, 5, random), {}, context).ok());
    EXPECT_EQ(std::count_if(context.warnings.begin(), context.warnings.end(),
                            [](const Warning& warning) { return warning.code == "W-FLD-001"; }),
              1);
}

}  // namespace
}  // namespace anatomesh::missing_slices_test
