#include "anatomesh/improve/reroute/edge_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <vector>

#include "anatomesh/improve/reroute/contour_loop.h"
#include "anatomesh/improve/reroute/neighbor_rings.h"
#include "anatomesh/improve/reroute/ring_ways.h"

namespace anatomesh::edge_path_test {
namespace {

constexpr std::uint32_t side = 5;
constexpr double anywhere = 100;

// A flat sheet of side x side vertices, shaken, in triangles.
struct Sheet {
    std::vector<Vec3> points;
    std::vector<Triangle> triangles;
    Plane plane = make_plane({0, 0, 0}, {0, 0, 1});

    explicit Sheet(unsigned seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> shift(-0.3, 0.3);
        for (std::uint32_t n = 0; n < side * side; ++n)
            points.push_back({n % side + shift(random), n / side + shift(random), 0});
        for (std::uint32_t y = 0; y + 1 < side; ++y) {
            for (std::uint32_t x = 0; x + 1 < side; ++x) {
                const std::uint32_t a = y * side + x;
                triangles.push_back({a, a + 1, a + side});
                triangles.push_back({a + 1, a + side + 1, a + side});
            }
        }
    }
};

bool all(std::uint32_t) {
    return true;
}

TEST(EdgePathSearch, a_way_is_edges_from_end_to_end_and_no_farther_than_allowed) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Sheet sheet(seed);
        const SurfaceGraph graph(sheet.points, sheet.triangles);
        for (const double most_mm : {0.4, 1.0, anywhere}) {
            EdgePathSearch search(sheet.points, graph, sheet.plane, most_mm);
            search.begin({0, side * side - 1});
            const auto between = search.find(EdgePathRule::all, {}, all);
            if (!between) {
                EXPECT_LT(most_mm, anywhere);
                continue;
            }
            EXPECT_TRUE(search.are_edges(*between));
            std::vector<Vec3> row;
            for (const std::uint32_t v : search.stretch()) row.push_back(sheet.points[v]);
            for (const std::uint32_t v : *between)
                EXPECT_LE(length(sheet.points[v] - nearest_on_row(row, sheet.points[v])), most_mm);
        }
    }
}

TEST(EdgePathSearch, a_way_keeps_off_vertices_that_it_may_not_pass) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Sheet sheet(seed);
        const SurfaceGraph graph(sheet.points, sheet.triangles);
        EdgePathSearch search(sheet.points, graph, sheet.plane, anywhere);
        search.begin({0, side * side - 1});
        const auto first = search.find(EdgePathRule::all, {}, all);
        ASSERT_TRUE(first && !first->empty());
        const auto may_pass = [&](std::uint32_t v) { return v != first->front(); };
        const auto other = search.find(EdgePathRule::all, {}, may_pass);
        ASSERT_TRUE(other);
        EXPECT_EQ(std::find(other->begin(), other->end(), first->front()), other->end());
        EXPECT_FALSE(search.find(EdgePathRule::all, {}, [](std::uint32_t v) { return v == 0; }));
    }
}

TEST(EdgePathSearch, a_clear_way_crosses_no_segment_and_an_onward_one_never_turns_back) {
    const std::vector<EdgePathSearch::Segment> wall{{2, 2 + 3 * side}};
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Sheet sheet(seed);
        const SurfaceGraph graph(sheet.points, sheet.triangles);
        EdgePathSearch search(sheet.points, graph, sheet.plane, anywhere);
        search.begin({0, side - 1});
        const auto clear = search.find(EdgePathRule::clear, wall, all);
        ASSERT_TRUE(clear);
        // Round the wall's free end, as its other end is on the rim: by a vertex of it or beyond.
        const auto is_round = [&](std::uint32_t v) { return v == 2 || v >= 2 * side; };
        EXPECT_TRUE(std::any_of(clear->begin(), clear->end(), is_round));
        if (const auto onward = search.find(EdgePathRule::onwards, {}, all)) {
            const Vec3 forward = sheet.points[side - 1] - sheet.points[0];
            double along = 0;
            for (const std::uint32_t v : *onward) {
                EXPECT_GT(dot(sheet.points[v] - sheet.points[0], forward), along);
                along = dot(sheet.points[v] - sheet.points[0], forward);
            }
        }
    }
}

TEST(RingWays, a_ring_with_ways_has_its_other_vertices_and_those_of_the_ways_in_order) {
    RoutedRing ring{{0, 1, 2, 3, 4, 5}, {}};
    EXPECT_EQ(with_ways(ring).vertices, ring.vertices);
    ring.ways.push_back({1, 2, 1, 1, {10, 11}, 0});
    ring.ways.push_back({5, 2, 5, 1, {12}, 0});
    const RingWithWays whole = with_ways(ring);
    EXPECT_EQ(whole.vertices, (std::vector<std::uint32_t>{1, 10, 11, 3, 4, 5, 12}));
    EXPECT_EQ(whole.way_of, (std::vector<std::size_t>{0, 0, 0, 2, 2, 1, 1}));
    for (std::uint32_t n = 0; n < ring.size(); ++n)
        EXPECT_EQ(ring.is_rerouted(n), n == 0 || n == 1 || n == 2 || n == 5) << n;
}

TEST(NeighborRings, hold_what_runs_inside_them_but_for_a_wall_that_they_share) {
    const std::vector<Vec3> points{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0},   // a square
                                   {1, 1, 0}, {2, 3, 0}, {3, 1, 0}, {9, 9, 0}};  // within it, and beyond
    const Plane plane = make_plane({0, 0, 0}, {0, 0, 1});
    NeighborRings others(points, plane);
    others.add({{0, 1, 2, 3}, {{0, 1, 0, 1, {6}, 0}}}, 1);
    EXPECT_TRUE(others.has(2));
    EXPECT_TRUE(others.has(6));
    EXPECT_FALSE(others.has(4));
    EXPECT_EQ(others.way_between(1, 0), std::vector<std::uint32_t>{6});
    EXPECT_FALSE(others.way_between(1, 2));
    const RoutedRing inside{{4, 7, 5}, {}};
    EXPECT_TRUE(others.hold(inside, {2, 1, 2, 1, {}, 0}));
    EXPECT_FALSE(others.hold(inside, {0, 1, 0, 1, {7}, 0}));
    const RoutedRing shared{{2, 1, 7}, {}};
    EXPECT_FALSE(others.hold(shared, {0, 1, 0, 1, {5}, 0}));
}

}  // namespace
}  // namespace anatomesh::edge_path_test
