#include "anatomesh/contour/resolve/doubled_rings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh::doubled_rings_test {
namespace {

// A wavy outline about the origin at z = 3, every point `outwards` mm further out.
std::vector<Vec3> outline(double outwards, int count, int waves, Vec3 moved = {0, 0, 0}) {
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * (i + 0.3) / count;
        const double radius = 20 + (waves == 0 ? 0 : 4 * std::cos(waves * angle)) + outwards;
        points.push_back(Vec3{radius * std::cos(angle), radius * std::sin(angle), 3} + moved);
    }
    return points;
}

struct Read {
    std::size_t contours = 0, repeats = 0, doubts = 0;
    double area = 0;
    std::vector<std::string> rules;
};

Read read(const std::vector<std::vector<Vec3>>& outlines, const CleanOptions& options = {}) {
    RawContours raw;
    raw.structures = {{1, "liver", {}}};
    for (const auto& points : outlines) {
        raw.contours.push_back({0, ContourKind::closed_planar, static_cast<std::uint32_t>(raw.points.size()),
                                static_cast<std::uint32_t>(points.size()), -1, ""});
        raw.points.insert(raw.points.end(), points.begin(), points.end());
    }
    RunContext context;
    auto result = clean_contours(raw, options, context);
    EXPECT_TRUE(result.ok());
    Read done;
    const ContourSet& kept = result.value().kept;
    done.contours = kept.contours.size();
    for (const Contour& contour : kept.contours) {
        std::vector<Vec2> at;
        for (Vec3 p : kept.points_of(contour)) at.push_back(kept.slices[0].plane.to_plane(p));
        done.area += signed_area(at);
    }
    for (const Warning& warning : context.warnings) {
        done.repeats += warning.code == "W-CON-011";
        done.doubts += warning.code == "W-CON-026";
    }
    for (const ContourLog& log : result.value().log) done.rules.push_back(log.rule);
    return done;
}

TEST(DoubledRings, C23_an_outline_drawn_again_a_hair_off_is_one_outline) {
    for (int waves : {0, 3, 5}) {
        const double area = read({outline(0, 90, waves)}).area;
        for (double off : {1e-6, 1e-4, 0.01, 0.045}) {
            for (double side : {-off, off}) {
                const Read nested = read({outline(0, 90, waves), outline(side, 90, waves)});
                EXPECT_EQ(nested.contours, 1u) << waves << " " << side;
                EXPECT_EQ(nested.repeats, 1u) << waves << " " << side;
                EXPECT_NEAR(nested.area, area, 150 * off + 1e-6);
                const Read beside = read({outline(0, 90, waves), outline(0, 90, waves, {side, 0, 0})});
                EXPECT_EQ(beside.contours, 1u) << waves << " " << side;
                EXPECT_EQ(beside.repeats, 1u) << waves << " " << side;
            }
        }
    }
}

TEST(DoubledRings, the_largest_of_many_is_kept_in_any_order) {
    const std::vector<std::vector<Vec3>> drawn{outline(0.02, 90, 3), outline(0, 90, 3), outline(0.04, 90, 3)};
    const double largest = read({drawn[2]}).area;
    for (const auto& order : {std::vector{0, 1, 2}, {2, 1, 0}, {1, 2, 0}}) {
        const Read run = read({drawn[order[0]], drawn[order[1]], drawn[order[2]]});
        EXPECT_EQ(run.contours, 1u);
        EXPECT_EQ(run.repeats, 2u);
        EXPECT_EQ(run.area, largest);
        for (int i = 0; i < 3; ++i) EXPECT_EQ(run.rules[i] == "outer", order[i] == 2) << run.rules[i];
    }
}

TEST(DoubledRings, what_lies_in_a_doubled_outline_keeps_its_meaning) {
    // Hole and island drawn once, the outline twice: without the repeat the hole would be an island.
    const Read run =
        read({outline(0, 90, 0), outline(-0.01, 90, 0), outline(-8, 60, 0), outline(-14, 40, 0)});
    EXPECT_EQ(run.contours, 3u);
    EXPECT_NEAR(run.area, M_PI * (400 - 144 + 36), 3);
}

TEST(DoubledRings, a_thin_wall_is_kept_and_asked_about) {
    for (double wall : {0.06, 0.2, 0.45}) {
        const Read run = read({outline(0, 90, 3), outline(-wall, 90, 3)});
        EXPECT_EQ(run.contours, 2u) << wall;
        EXPECT_EQ(run.repeats, 0u) << wall;
        EXPECT_EQ(run.doubts, 1u) << wall;
        EXPECT_LT(run.area, 160 * wall);
    }
    EXPECT_EQ(read({outline(0, 90, 3), outline(-0.8, 90, 3)}).doubts, 0u);
    CleanOptions filled;
    filled.rings.holes = HoleRule::united;
    EXPECT_EQ(read({outline(0, 90, 3), outline(-0.2, 90, 3)}, filled).doubts, 0u);
}

// However fine their vertices, nobody but the user knows; but what is small has walls that thin.
TEST(DoubledRings,
     faces_with_vertices_as_fine_as_the_wall_are_a_wall_that_is_asked_about_round_what_is_large) {
    for (const int fine : {250, 500, 1000, 4000}) {  // 0.5 to 0.03 mm apart
        for (const double wall : {0.04, 0.1, 0.3, 0.45}) {
            const bool repeats = wall < 0.05 && fine <= 1000;
            const Read run = read({outline(0, fine, 0), outline(-wall, fine, 0)});
            EXPECT_EQ(run.contours, repeats ? 1u : 2u) << fine << ' ' << wall;
            EXPECT_EQ(run.repeats, repeats ? 1u : 0u) << fine << ' ' << wall;
            EXPECT_EQ(run.doubts, repeats ? 0u : 1u) << fine << ' ' << wall;
        }
        const Read tube = read({outline(-17.5, fine, 0), outline(-17.9, fine, 0)});
        EXPECT_EQ(tube.contours, 2u);
        EXPECT_EQ(tube.repeats + tube.doubts, 0u);
    }
}

TEST(DoubledRings, rings_that_follow_each_other_on_one_side_only_are_not_doubled) {
    const Read run = read({outline(0, 90, 0), outline(-0.5, 90, 0, {0.47, 0, 0})});
    EXPECT_EQ(run.contours, 2u);
    EXPECT_EQ(run.repeats + run.doubts, 0u);
}

TEST(DoubledRings, the_distance_is_the_largest_of_both_ways) {
    const Plane plane = make_plane({0, 0, 3}, {0, 0, 1});
    std::vector<Ring> rings{make_ring(outline(0, 30, 0), plane, 0), make_ring(outline(0.3, 30, 0), plane, 1)};
    std::vector<DoubledRings> pairs = find_doubled_rings(rings, 0.5);
    ASSERT_EQ(pairs.size(), 1u);
    EXPECT_EQ(pairs[0].smaller, 0u);
    EXPECT_EQ(pairs[0].larger, 1u);
    EXPECT_NEAR(pairs[0].apart_mm, 0.3, 0.01);
    EXPECT_TRUE(find_doubled_rings(rings, 0.25).empty());
    // One vertex of the larger far out.
    rings[1].at[4] = 1.1 * rings[1].at[4];
    EXPECT_TRUE(find_doubled_rings(rings, 0.5).empty());
    // Other planes given: they have a rule of their own.
    rings[1] = make_ring(outline(0.3, 30, 0), plane, 1);
    rings[1].plane = 7;
    EXPECT_TRUE(find_doubled_rings(rings, 0.5).empty());
}

}  // namespace
}  // namespace anatomesh::doubled_rings_test
