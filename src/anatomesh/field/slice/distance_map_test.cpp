#include "anatomesh/field/slice/distance_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh::distance_map_test {
namespace {

using namespace fixtures;

double distance_to(const Edge2& edge, Vec2 q) {
    const Vec2 along = edge.b - edge.a;
    const double t = std::clamp(dot(q - edge.a, along) / squared_length(along), 0.0, 1.0);
    return length(q - edge.a - t * along);
}

// Exact even-odd side: 1 outside, -1 inside, 0 on an edge.
int side_of(const std::vector<Edge2>& edges, Vec2 q) {
    int side = 1;
    for (const Edge2& e : edges) {
        const int turn = orient2d(e.a, e.b, q);
        if (turn == 0 && dot(q - e.a, q - e.b) <= 0) return 0;
        if ((e.a.y <= q.y) != (e.b.y <= q.y) && (turn > 0) == (e.b.y > e.a.y)) side = -side;
    }
    return side;
}

double brute_force(const std::vector<Edge2>& edges, Vec2 q, double limit) {
    double nearest = limit;
    for (const Edge2& e : edges) nearest = std::min(nearest, distance_to(e, q));
    return side_of(edges, q) * nearest;
}

void expect_equals_brute_force(const std::vector<Edge2>& edges, const DistanceMap& map, std::mt19937& random,
                               int count) {
    const Box2 box = map.box().grown(1);
    std::uniform_real_distribution<double> x(box.low.x, box.high.x), y(box.low.y, box.high.y);
    for (int i = 0; i < count; ++i) {
        const Vec2 q{x(random), y(random)};
        ASSERT_NEAR(map.value(q), brute_force(edges, q, map.limit()), 1e-12) << q.x << " " << q.y;
    }
}

TEST(DistanceMap, equals_brute_force_on_random_polygons_with_holes) {
    std::mt19937 random(7);
    for (const double limit : {0.3, 2.0, 9.0}) {
        for (const double cell : {0.0, 0.2, 1.0, 15.0}) {
            for (int trial = 0; trial < 6; ++trial) {
                const Vec2 at{100.0 * trial, -37.5};
                const std::vector<Edge2> edges =
                    edges_of({star(at, 8, 20, 13 + 40 * trial, random), reversed(star(at, 3, 7.9, 9, random)),
                              star(at, 0.5, 2.9, 30, random), star(at + Vec2{41, 2}, 1, 15, 50, random)});
                const DistanceMap map(edges, limit, cell);
                expect_equals_brute_force(edges, map, random, 1500);
            }
        }
    }
}

// Queries crowded around vertices and edges, down to distances of the order of the rounding.
TEST(DistanceMap, sign_is_that_of_exact_arithmetic_near_the_boundary) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int trial = 0; trial < 20; ++trial) {
        const Vec2 at{1000.0 * trial, 5.0};
        const std::vector<Edge2> edges =
            edges_of({star(at, 2, 20, 60, random), reversed(star(at, 0.1, 1.9, 20, random))});
        const DistanceMap map(edges, 2.0);
        for (const Edge2& edge : edges) {
            for (const double scale : {1e-3, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-15}) {
                const double t = 0.5 + 0.5 * unit(random);
                for (const Vec2 base : {edge.a, edge.a + t * (edge.b - edge.a)}) {
                    const Vec2 q = base + Vec2{scale * unit(random), scale * unit(random)};
                    const double value = map.value(q);
                    const int sign = (value > 0) - (value < 0);
                    ASSERT_EQ(sign, side_of(edges, q)) << "trial " << trial << " scale " << scale;
                }
            }
        }
    }
}

TEST(DistanceMap, C06_walls_closer_than_rounding_of_distances_keep_their_sides) {
    for (const double gap : {1e-6, 1e-12, 1e-14}) {
        const Ring left{{0, 0}, {1, 0}, {1, 9}, {0, 9}}, right{{1 + gap, 0}, {2, 0}, {2, 9}, {1 + gap, 9}};
        const std::vector<Edge2> edges = edges_of({left, right});
        const DistanceMap map(edges, 1.0);
        std::mt19937 random(3);
        std::uniform_real_distribution<double> x(1 - 2 * gap, 1 + 3 * gap), y(0.1, 8.9);
        for (int i = 0; i < 2000; ++i) {
            const Vec2 q{x(random), y(random)};
            const double value = map.value(q);
            ASSERT_EQ((value > 0) - (value < 0), side_of(edges, q));
        }
        EXPECT_LT(map.value({0.5, 4}), 0);
        EXPECT_LT(map.value({1.5, 4}), 0);
    }
}

TEST(DistanceMap, zero_exactly_at_every_vertex_and_nowhere_off_the_boundary) {
    std::mt19937 random(5);
    const std::vector<Edge2> edges = edges_of({star({123.456, -98.7}, 5, 30, 400, random)});
    const DistanceMap map(edges, 1.5);
    for (const Edge2& edge : edges) {
        EXPECT_EQ(map.value(edge.a), 0.0);
        EXPECT_NE(map.value({std::nextafter(edge.a.x, 1e9), edge.a.y}), 0.0);
    }
}

TEST(DistanceMap, C08_contours_that_share_a_vertex) {
    // A square hole that touches the outer square at a corner, and two squares that touch at a corner.
    const std::vector<Edge2> edges = edges_of({{{0, 0}, {4, 0}, {4, 4}, {0, 4}},
                                               {{0, 0}, {1, 2}, {2, 2}, {2, 1}},
                                               {{4, 4}, {6, 4}, {6, 6}, {4, 6}}});
    const DistanceMap map(edges, 1.0);
    std::mt19937 random(1);
    expect_equals_brute_force(edges, map, random, 5000);
    EXPECT_EQ(map.value({0, 0}), 0.0);
    EXPECT_EQ(map.value({4, 4}), 0.0);
    EXPECT_GT(map.value({4.1, 3.9}), 0);
    EXPECT_LT(map.value({3.9, 3.9}), 0);
}

TEST(DistanceMap, C14_C35_fine_points_beside_long_edges_and_thin_sheets) {
    Ring comb;
    for (int i = 0; i <= 1000; ++i) comb.push_back({1e-3 * i, 0});
    comb.insert(comb.end(), {{500, 0}, {500, 0.05}, {0, 0.05}});
    const std::vector<Edge2> edges = edges_of({comb});
    const DistanceMap map(edges, 2.0);
    std::mt19937 random(2);
    expect_equals_brute_force(edges, map, random, 3000);
    EXPECT_LT(map.bytes(), 4u << 20);
}

// A circle of n edges with a ripple, in both directions, and beside it a hole.
std::vector<Edge2> fine_rings(int n, bool against) {
    Ring outer, inner;
    for (int i = 0; i < n; ++i) {
        const double turn = 2 * 3.14159265358979 * i / n, radius = 10 + 0.3 * std::sin(40 * turn);
        outer.push_back({radius * std::cos(turn), radius * std::sin(turn)});
        inner.push_back({3 + 2 * std::cos(turn), 2 * std::sin(turn)});
    }
    std::vector<Edge2> edges = edges_of({outer, reversed(inner)});
    if (against) std::reverse(edges.begin(), edges.end());
    return edges;
}

TEST(DistanceMap, equals_brute_force_on_contours_much_finer_than_its_cells) {
    std::mt19937 random(12);
    for (const double limit : {0.5, 3.0, 20.0}) {
        for (const bool against : {false, true}) {
            std::vector<Edge2> edges = fine_rings(3000, against);
            expect_equals_brute_force(edges, DistanceMap(edges, limit), random, 1500);
            // In any order of the edges, and broken into crumbs.
            std::shuffle(edges.begin(), edges.end(), random);
            expect_equals_brute_force(edges, DistanceMap(edges, limit), random, 300);
        }
    }
    std::vector<Ring> crumbs;
    for (int i = 0; i < 40; ++i) {
        for (int j = 0; j < 40; ++j) crumbs.push_back(star({0.1 * i, 0.1 * j}, 0.01, 0.045, 5, random));
    }
    const std::vector<Edge2> edges = edges_of(crumbs);
    expect_equals_brute_force(edges, DistanceMap(edges, 3.0), random, 1500);
}

// Every value is that of a map whose cells are so small that no list is long, to the last bit.
TEST(DistanceMap, strips_change_no_bit) {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> at(-13, 13);
    for (const bool against : {false, true}) {
        const std::vector<Edge2> edges = fine_rings(4000, against);
        const DistanceMap map(edges, 1.0), fine(edges, 1.0, 0.02);
        ASSERT_LT(fine.cell(), 0.1);
        for (int i = 0; i < 40000; ++i) {
            const Vec2 q{at(random), at(random)};
            ASSERT_EQ(map.value(q), fine.value(q));
        }
        for (const Edge2& edge : edges) ASSERT_EQ(map.value(edge.a), 0.0);
    }
}

TEST(DistanceMap, what_a_query_looks_at_hardly_grows_with_the_density_of_the_contour) {
    for (const double limit : {1.5, 15.0}) {
        double before = 0;
        for (const int n : {500, 4000, 32000}) {
            const std::vector<Edge2> edges = fine_rings(n, false);
            const DistanceMap map(edges, limit);
            std::mt19937 random(14);
            std::uniform_real_distribution<double> at(-11, 11);
            double steps = 0;
            for (int i = 0; i < 4000; ++i)
                steps += static_cast<double>(map.steps({at(random), at(random)})) / 4000;
            EXPECT_LT(steps, 150) << n << " limit " << limit;
            if (n == 32000) {
                EXPECT_LT(steps, 1.7 * before) << " limit " << limit;
            }
            EXPECT_LT(map.bytes(), 150 * edges.size() + 100000) << n << " limit " << limit;
            before = steps;
        }
    }
}

TEST(DistanceMap, moves_with_the_region) {
    std::mt19937 random(9);
    const Ring shape = star({0, 0}, 4, 9, 70, random);
    Ring moved = shape;
    const Vec2 shift{1024, -4096};
    for (Vec2& p : moved) p = p + shift;
    const DistanceMap map(edges_of({shape}), 2.0), other(edges_of({moved}), 2.0);
    std::uniform_real_distribution<double> at(-12, 12);
    for (int i = 0; i < 5000; ++i) {
        const Vec2 q{at(random), at(random)};
        ASSERT_NEAR(map.value(q), other.value(q + shift), 1e-11);
    }
    EXPECT_NEAR(map.area(), area_of(shape), 1e-9);
}

TEST(DistanceMap, bounds_hold) {
    std::vector<Edge2> edges;
    constexpr int n = 60;
    const auto corner = [](int i) {
        const double turn = 2 * 3.14159265358979 * i / n, radius = i % 2 ? 10.0 : 7.5;
        return Vec2{radius * std::cos(turn), 0.8 * radius * std::sin(turn)};
    };
    for (int i = 0; i < n; ++i) edges.push_back({corner(i), corner((i + 1) % n)});
    const DistanceMap map(edges, 3);
    std::size_t known = 0, count = 0;
    for (double x = -14; x < 14; x += 0.11) {
        for (double y = -14; y < 14; y += 0.13) {
            const double value = map.value({x, y});
            const DistanceMap::Bound bound = map.bound({x, y});
            ++count;
            if (bound.sign == 0) continue;
            ++known;
            ASSERT_EQ(bound.sign, value < 0 ? -1 : 1);
            ASSERT_GE(std::abs(value), bound.at_least);
            for (const double reach : {0.0, 0.7, 5.0}) {
                const double within = map.value_within({x, y}, reach);
                ASSERT_EQ(within < 0, value < 0);
                ASSERT_TRUE(within == value || std::min(std::abs(within), std::abs(value)) > reach);
            }
        }
    }
    EXPECT_GT(2 * known, count);
}

}  // namespace
}  // namespace anatomesh::distance_map_test
