#include "anatomesh/contour/simplify/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "anatomesh/contour/contour_laws_test.h"

namespace anatomesh::simplify_test {
namespace {

struct Drawn {
    std::uint32_t structure;
    std::vector<Vec2> polygon;
};

ContourSet one_slice(const std::vector<Drawn>& drawn, Plane plane = {}) {
    ContourSet set;
    set.slices.push_back({plane, 0, static_cast<std::uint32_t>(drawn.size()), "0"});
    std::uint32_t structures = 0;
    for (const Drawn& d : drawn) {
        set.contours.push_back({d.structure, 0, static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(d.polygon.size())});
        for (const Vec2 q : d.polygon) set.points.push_back(plane.to_space(q));
        structures = std::max(structures, d.structure + 1);
    }
    for (std::uint32_t s = 0; s < structures; ++s)
        set.structures.push_back({static_cast<std::int32_t>(s + 1), "", {}});
    return set;
}

std::vector<Vec2> star(Vec2 centre, double radius, double depth, int lobes, int points,
                       bool clockwise = false) {
    std::vector<Vec2> polygon;
    for (int n = 0; n < points; ++n) {
        const double angle = 2 * std::numbers::pi * (clockwise ? points - n : n) / points;
        const double r = radius + depth * std::sin(lobes * angle);
        polygon.push_back(centre + r * Vec2{std::cos(angle), std::sin(angle)});
    }
    return polygon;
}

SimplifyResult simplify(const ContourSet& set, double epsilon, double spacing = 0) {
    RunContext context;
    auto result = simplify_contours(set, {epsilon, spacing}, context);
    EXPECT_TRUE(result.ok());
    return std::move(result).value();
}

// The distance of every input vertex from its own contour, found by its order in the slice of one contour.
double farthest_vertex(const ContourSet& before, const ContourSet& after) {
    double worst = 0;
    for (const Vec3& point : before.points) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Contour& contour : after.contours) {
            const Vec2 q = after.slices[0].plane.to_plane(point);
            nearest = std::min(nearest, distance_to_polygon(q, in_plane(after, contour)));
        }
        worst = std::max(worst, nearest);
    }
    return worst;
}

TEST(Simplify, zero_keeps_all) {
    const ContourSet set = one_slice({{0, star({0, 0}, 10, 2, 5, 300)}});
    const SimplifyResult result = simplify(set, 0);
    EXPECT_EQ(result.kept.points, set.points);
    EXPECT_EQ(result.stats.points_kept, 300u);
    EXPECT_EQ(result.stats.max_distance_mm, 0);
}

TEST(Simplify, keeps_within_the_bound_and_at_exact_coordinates) {
    const Plane plane = make_plane({10, -20, 30}, {0.3, -0.5, 0.8});
    const ContourSet set = one_slice({{0, star({0.1, 3}, 30, 5, 7, 2000)}}, plane);
    std::size_t before = 2000;
    for (const double epsilon : {0.001, 0.01, 0.1, 1.0, 9.0}) {
        const SimplifyResult result = simplify(set, epsilon);
        EXPECT_LE(result.stats.max_distance_mm, epsilon);
        EXPECT_LE(farthest_vertex(set, result.kept), result.stats.max_distance_mm + 1e-12);
        EXPECT_LT(result.kept.points.size(), before);
        EXPECT_GE(result.kept.points.size(), 3u);
        before = result.kept.points.size();
        for (const Vec3& point : result.kept.points) {
            EXPECT_NE(std::find(set.points.begin(), set.points.end(), point), set.points.end());
        }
        expect_kept_contour_set(result.kept);
    }
}

TEST(Simplify, needs_no_more_vertices_than_the_shape_has_corners) {
    std::vector<Vec2> square;
    const Vec2 corners[] = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    for (int side = 0; side < 4; ++side) {
        for (int n = 0; n < 50; ++n)
            square.push_back(corners[side] + (n / 50.0) * (corners[(side + 1) % 4] - corners[side]));
    }
    std::rotate(square.begin(), square.begin() + 17, square.end());  // starts on a side
    const SimplifyResult result = simplify(one_slice({{0, square}}), 0.01);
    EXPECT_EQ(result.kept.points.size(), 4u);
    EXPECT_NEAR(signed_area(in_plane(result.kept, result.kept.contours[0])), 100, 1e-9);
}

TEST(Simplify, rings_closer_than_the_bound_stay_nested) {
    // Walls of a tenth of the bound, and an island within the bound of the wall.
    const ContourSet set = one_slice({{0, star({0, 0}, 20, 3, 9, 900)},
                                      {0, star({0, 0}, 19.95, 3, 9, 900, true)},
                                      {1, star({0, 0}, 19.9, 3, 9, 900)},
                                      {2, star({22.2, 6.1}, 0.05, 0, 1, 12)}});
    expect_orientation(set, set.slices[0]);
    for (const double epsilon : {0.05, 0.5, 2.0, 5.0}) {
        const SimplifyResult result = simplify(set, epsilon);
        EXPECT_LT(result.kept.points.size(), set.points.size());
        expect_kept_contour_set(result.kept);
        const auto in = [&](std::size_t a, std::size_t b) {
            return encloses(in_plane(result.kept, result.kept.contours[b]),
                            in_plane(result.kept, result.kept.contours[a]).front());
        };
        // By structure, then by smallest vertex: outer, inner, next, island.
        EXPECT_TRUE(in(1, 0) && in(2, 1) && in(2, 0)) << epsilon;
        for (std::size_t ring = 0; ring < 3; ++ring) {
            EXPECT_EQ(in(3, ring),
                      encloses(in_plane(set, set.contours[ring]), in_plane(set, set.contours[3]).front()));
        }
    }
}

TEST(Simplify, a_small_contour_is_not_jumped_over) {
    // A bay less deep than the bound with a tiny island in it.
    std::vector<Vec2> bay{{0, 0}, {4, 0}, {5, 0.4}, {6, 0}, {10, 0}, {10, 10}, {0, 10}};
    const ContourSet set = one_slice({{0, bay}, {1, {{4.95, 0.1}, {5.05, 0.1}, {5, 0.2}}}});
    const SimplifyResult alone = simplify(one_slice({{0, bay}}), 0.5), both = simplify(set, 0.5);
    EXPECT_EQ(alone.kept.contours[0].point_count, 4u);
    EXPECT_GT(both.kept.contours[0].point_count, 4u);
    EXPECT_FALSE(encloses(in_plane(both.kept, both.kept.contours[0]), {5, 0.15}));
}

TEST(Simplify, a_shared_wall_stays_shared) {
    // A disc in two halves with a wavy wall.
    std::vector<Vec2> wall;
    for (int n = 0; n <= 200; ++n) wall.push_back({std::sin(n * std::numbers::pi / 20), n * 0.2 - 20});
    std::vector<Vec2> right = wall, left(wall.rbegin(), wall.rend());
    const auto arc = [](double from, std::vector<Vec2>& polygon) {
        for (int n = 1; n < 150; ++n) {
            const double angle = from + n * std::numbers::pi / 150;
            polygon.push_back({20 * std::cos(angle), 20 * std::sin(angle)});
        }
    };
    arc(std::numbers::pi / 2, right);
    arc(-std::numbers::pi / 2, left);
    const ContourSet set = one_slice({{0, right}, {1, left}});
    expect_no_crossing(set, set.slices[0]);
    for (const double epsilon : {0.02, 0.3, 3.0}) {
        const SimplifyResult result = simplify(set, epsilon, 0.1);
        std::set<std::pair<double, double>> of[2];
        for (const Contour& contour : result.kept.contours) {
            for (const Vec2 q : in_plane(result.kept, contour)) {
                if (std::abs(q.x) <= 1 && std::abs(q.y) <= 20 && length(q) < 19.99)
                    of[contour.structure].insert({q.x, q.y});
            }
        }
        EXPECT_EQ(of[0], of[1]);
        EXPECT_LT(result.kept.points.size(), set.points.size() / 2);
        expect_no_crossing(result.kept, result.kept.slices[0]);
    }
}

TEST(Simplify, contours_that_cross_before_may_cross_after) {
    const ContourSet set = one_slice({{0, star({0, 0}, 20, 1, 4, 500)}, {1, star({15, 3}, 18, 2, 6, 500)}});
    const SimplifyResult result = simplify(set, 0.2);
    EXPECT_LT(result.kept.points.size(), 300u);
    expect_kept_contour_set(result.kept, false);
    // Each one alone stays simple.
    for (const std::uint32_t s : {0u, 1u}) {
        ContourSet alone = one_slice({{s, in_plane(result.kept, result.kept.contours[s])}});
        expect_no_crossing(alone, alone.slices[0]);
    }
}

TEST(Simplify, random_tangles_of_near_walls_never_cross) {
    std::mt19937 random(3);
    const auto number = [&](double low, double high) {
        return low + (high - low) * (random() / 4294967296.0);
    };
    for (int round = 0; round < 40; ++round) {
        std::vector<Drawn> drawn;
        double radius = 20;
        const int lobes = 3 + static_cast<int>(random() % 20), points = 60 + static_cast<int>(random() % 400);
        const double depth = number(0, 3);
        for (std::uint32_t s = 0; s < 8; ++s) {
            drawn.push_back({s % 3, star({0, 0}, radius, depth, lobes, points)});
            radius -= number(0.02, 0.5);
        }
        // Structures alternate: direction follows from the depth in their own.
        for (std::size_t s = 0; s < drawn.size(); ++s) {
            if (s / 3 % 2 == 1) std::reverse(drawn[s].polygon.begin(), drawn[s].polygon.end());
        }
        const ContourSet set = one_slice(drawn);
        for (const double epsilon : {0.05, 0.4, 1.5, 6.0}) {
            const SimplifyResult result = simplify(set, epsilon, round % 2 == 0 ? 0.3 : 0.0);
            expect_no_crossing(result.kept, result.kept.slices[0]);
            expect_orientation(result.kept, result.kept.slices[0]);
            EXPECT_LE(result.stats.max_distance_mm, epsilon);
        }
    }
}

TEST(Simplify, the_order_and_start_of_the_contours_do_not_matter) {
    std::vector<Drawn> drawn{{0, star({0, 0}, 20, 2, 5, 400)},
                             {1, star({0, 0}, 15, 2, 5, 300)},
                             {1, star({60, 0}, 15, 1, 5, 200)}};
    const SimplifyResult a = simplify(one_slice(drawn), 0.3, 0.5);
    std::swap(drawn[0], drawn[2]);
    for (Drawn& d : drawn) std::rotate(d.polygon.begin(), d.polygon.begin() + 31, d.polygon.end());
    const SimplifyResult b = simplify(one_slice(drawn), 0.3, 0.5);
    EXPECT_EQ(a.kept.points, b.kept.points);
}

TEST(Simplify, asked_for_spacing_is_kept_where_the_bound_allows) {
    const ContourSet set = one_slice({{0, star({0, 0}, 20, 2, 4, 1500)}});
    const SimplifyResult result = simplify(set, 0.05, 1.0);
    const std::vector<Vec2> polygon = in_plane(result.kept, result.kept.contours[0]);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        EXPECT_GE(length(polygon[(i + 1) % polygon.size()] - polygon[i]), 1.0);
    }
}

TEST(Simplify, a_structure_that_loses_area_is_named_and_holes_count_as_holes) {
    // The first structure is a wall of 6 mm, the second a disc so large that the bound means little to it.
    ContourSet set = one_slice({{0, star({0, 0}, 20, 0, 1, 200)},
                                {0, star({0, 0}, 14, 0, 1, 200, true)},
                                {1, star({300, 0}, 200, 0, 1, 2000)}});
    set.structures[0].name = "wall";
    for (const double epsilon : {0.0, 0.1, 4.0}) {
        RunContext context;
        ASSERT_TRUE(simplify_contours(set, {epsilon, 0}, context).ok());
        if (epsilon < 1) {
            EXPECT_TRUE(context.warnings.empty());
            continue;
        }
        ASSERT_EQ(context.warnings.size(), 1u);
        EXPECT_EQ(context.warnings[0].code, "W-CON-024");
        EXPECT_EQ(context.warnings[0].place.structure, "wall");
    }
}

TEST(Simplify, triangles_stay) {
    const ContourSet set =
        one_slice({{0, {{0, 0}, {0.01, 0}, {0, 0.01}}}, {0, {{5, 5}, {6, 5}, {5, 5.001}}}});
    EXPECT_EQ(simplify(set, 10).kept.points, set.points);
}

}  // namespace
}  // namespace anatomesh::simplify_test
