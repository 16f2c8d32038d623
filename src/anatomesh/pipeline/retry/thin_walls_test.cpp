#include "anatomesh/pipeline/retry/thin_walls.h"

#include <gtest/gtest.h>

#include "anatomesh/pipeline/solid_fixtures_for_test.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::thin_walls_test {
namespace {

using namespace fixtures;

// Discs of two structures with `gap` between their outlines all round, or round a part of them.
ContourSet discs(double gap, double shifted = 0) {
    Drawing drawing;
    for (int k = 0; k < 6; ++k) {
        drawing.add(0, 3 * k, circle({}, 20, 60));
        drawing.add(1, 3 * k, circle({shifted, 0}, 20 - gap, 60));
    }
    return kept(drawing.raw);
}

TEST(WallSize, is_two_and_a_half_times_the_thickness_of_a_wall_all_round) {
    for (const double gap : {0.1, 0.2, 0.5}) {
        const auto walls = wall_size(discs(gap), 3, 3);
        ASSERT_TRUE(walls) << gap;
        EXPECT_NEAR(walls->thickness_mm / gap, 1, 0.02);
        EXPECT_NEAR(walls->size_mm / (2.5 * gap), 1, 0.02);
        EXPECT_NEAR(walls->cells * walls->size_mm * walls->size_mm / (75 * 12 * 2 * pi * 20 * 3), 1, 0.03);
        EXPECT_EQ(walls->share, 1);
    }
}

TEST(WallSize, none_where_walls_are_thick_or_thin_in_places_only) {
    EXPECT_FALSE(wall_size(discs(1), 3, 3));
    EXPECT_FALSE(wall_size(discs(0.5, 5), 3, 3));
    EXPECT_FALSE(wall_size(discs(0), 3, 3));  // one outline drawn for both
}

TEST(WallSize, is_of_the_structures_with_walls_alone) {
    ContourSet set = discs(0.2);
    set.structures.push_back({3, "another", {}});
    for (Contour& contour : set.contours) {
        if (contour.slice >= 3) contour.structure = 2;
    }
    const auto walls = wall_size(set, 3, 3);
    ASSERT_TRUE(walls);
    EXPECT_NEAR(walls->share, 0.5, 0.01);
}

// Two balls of 12 mm, one in the other, on slices across and as many along.
ContourSet nested_balls(double gap, int slices) {
    Drawing drawing;
    for (const bool along : {false, true}) {
        Drawing part;
        for (int k = 0; k < slices; ++k) {
            const double at = 4.0 * k - 2 * (slices - 1);
            for (std::uint32_t s = 0; s < 2; ++s)
                part.add(s, at, circle({}, std::sqrt((12 - gap * s) * (12 - gap * s) - at * at), 36));
        }
        if (along) part.move([](Vec3 p) { return Vec3{p.z + 0.1, p.x, p.y}; });
        for (RawContour contour : part.raw.contours) {
            contour.first_point += static_cast<std::uint32_t>(drawing.raw.points.size());
            drawing.raw.contours.push_back(contour);
        }
        drawing.raw.points.insert(drawing.raw.points.end(), part.raw.points.begin(), part.raw.points.end());
        drawing.raw.structures = part.raw.structures;
    }
    RunContext context;
    auto reconciled = reconcile_contours(kept(drawing.raw), {}, context);
    EXPECT_TRUE(reconciled.ok());
    return std::move(reconciled).value().kept;
}

TEST(WallSize, nested_structures_where_planes_cross_keep_the_contract_with_it) {
    const auto made = build(nested_balls(0.3, 5));
    ASSERT_TRUE(made.ok()) << to_line(made.error());
    for (const Clause& clause : made.value().report.certificate)
        EXPECT_EQ(clause.state, ClauseState::kept) << clause.evidence;
}

TEST(WallSize, walls_too_thin_for_any_model_are_named) {
    const auto made = build(nested_balls(0.02, 3));
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, "E-PIP-002");
    EXPECT_NE(made.error().next_step.find(" mm beside each other nearly everywhere"), std::string::npos)
        << made.error().next_step;
}

}  // namespace
}  // namespace anatomesh::thin_walls_test
