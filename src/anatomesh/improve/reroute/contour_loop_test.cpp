#include "anatomesh/improve/reroute/contour_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace anatomesh::contour_loop_test {
namespace {

// A regular polygon of radius 1: vertex n is number 100 + n.
ContourLoop polygon(std::size_t count) {
    std::vector<std::uint32_t> vertices;
    std::vector<Vec3> places;
    for (std::size_t n = 0; n < count; ++n) {
        vertices.push_back(static_cast<std::uint32_t>(100 + n));
        const double angle = 2 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(count);
        places.push_back({std::cos(angle), std::sin(angle), 0});
    }
    return {vertices, places};
}

std::vector<std::uint32_t> vertices_of(const ContourLoop& loop) {
    std::vector<std::uint32_t> vertices;
    for (std::size_t n = 0; n < loop.size(); ++n) vertices.push_back(loop.corner(n).vertex);
    return vertices;
}

// Of two cycles, where they start left aside.
bool same_cycle(std::vector<std::uint32_t> one, const std::vector<std::uint32_t>& other) {
    if (one.size() != other.size()) return false;
    for (std::size_t n = 0; n < one.size(); ++n) {
        if (one == other) return true;
        std::rotate(one.begin(), one.begin() + 1, one.end());
    }
    return false;
}

// The ends of a stretch given by whole corners; two vertices in between.
LoopStretch stretch_of(const ContourLoop& loop, double from, double to, std::uint32_t first_new) {
    const auto vertex = [&](double at) { return loop.drawn(static_cast<std::int64_t>(at)); };
    LoopStretch stretch{from, to, {vertex(from), first_new, first_new + 1, vertex(to)}, {}};
    const Vec3 a = loop.drawn_between(from, to).front(), b = loop.drawn_between(from, to).back();
    for (int n = 0; n < 4; ++n) stretch.places.push_back(a + n / 3.0 * (b - a));
    return stretch;
}

TEST(ContourLoop, a_stretch_takes_the_place_of_what_is_between_its_ends_wherever_the_loop_starts) {
    constexpr int count = 9;
    for (int from = -count; from <= count; ++from) {
        for (int length = 1; length <= count - 2; ++length) {
            SCOPED_TRACE(std::to_string(from) + " + " + std::to_string(length));
            ContourLoop loop = polygon(count);
            ASSERT_TRUE(loop.replace(stretch_of(loop, from, from + length, 7)));
            std::vector<std::uint32_t> expected;
            for (int n = from + length; n <= from + count; ++n) expected.push_back(loop.drawn(n));
            expected.insert(expected.end(), {7, 8});
            EXPECT_TRUE(same_cycle(vertices_of(loop), expected));
            for (std::size_t n = 0; n < loop.size(); ++n) {
                EXPECT_GE(loop.corner(n).at, 0);
                EXPECT_LT(loop.corner(n).at, count);
                EXPECT_LE(loop.corner(n - (n > 0)).at, loop.corner(n).at);
            }
        }
    }
}

TEST(ContourLoop, keeps_its_order_through_many_stretches) {
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        ContourLoop loop = polygon(12);
        std::vector<std::uint32_t> expected = vertices_of(loop);
        for (std::uint32_t k = 0; k < 5; ++k) {
            // From one corner of what there is to another one.
            const std::size_t n = random() % loop.size(), steps = 1 + random() % 3;
            const LoopCorner start = loop.corner(n);
            LoopCorner end = start;
            for (std::size_t m = 0; m < steps; ++m) end = loop.beside(n + m, end.at, 1);
            const std::vector<Vec3> drawn = loop.drawn_between(start.at, end.at);
            const std::uint32_t made = 1000 + k;
            ASSERT_TRUE(loop.replace({start.at,
                                      end.at,
                                      {start.vertex, made, end.vertex},
                                      {drawn.front(), 0.5 * (drawn.front() + drawn.back()), drawn.back()}}));
            std::rotate(expected.begin(), std::find(expected.begin(), expected.end(), start.vertex),
                        expected.end());
            expected.erase(expected.begin() + 1, expected.begin() + static_cast<std::ptrdiff_t>(steps));
            expected.insert(expected.begin() + 1, made);
            ASSERT_TRUE(same_cycle(vertices_of(loop), expected)) << round;
        }
    }
}

TEST(ContourLoop, keeps_three_corners) {
    ContourLoop loop = polygon(3);
    const std::vector<std::uint32_t> before = vertices_of(loop);
    // All but one segment, straight from end to end.
    EXPECT_FALSE(loop.replace({1, 3, {101, 100}, {{0, 0, 0}, {1, 0, 0}}}));
    EXPECT_EQ(vertices_of(loop), before);
}

TEST(ContourLoop, the_corner_beside_counts_on_past_the_end) {
    const ContourLoop loop = polygon(5);
    EXPECT_EQ(loop.beside(4, 4, 1).vertex, 100u);
    EXPECT_EQ(loop.beside(4, 4, 1).at, 5);
    EXPECT_EQ(loop.beside(0, 0, -1).vertex, 104u);
    EXPECT_EQ(loop.beside(0, 0, -1).at, -1);
    EXPECT_EQ(loop.beside(0, 5, -1).at, 4);
}

TEST(ContourLoop, what_is_drawn_between_two_places_has_the_corners_there) {
    const ContourLoop loop = polygon(4);
    const std::vector<Vec3> row = loop.drawn_between(-0.5, 1.25);
    ASSERT_EQ(row.size(), 4u);  // the ends, and corners 0 and 1
    EXPECT_LT(length(row[0] - Vec3{0.5, -0.5, 0}), 1e-12);
    EXPECT_LT(length(row[1] - Vec3{1, 0, 0}), 1e-12);
    EXPECT_LT(length(row[2] - Vec3{0, 1, 0}), 1e-12);
    EXPECT_LT(length(row[3] - Vec3{-0.25, 0.75, 0}), 1e-12);
}

TEST(Rows, distances_are_taken_both_ways) {
    const std::vector<Vec3> straight{{0, 0, 0}, {4, 0, 0}}, peak{{0, 0, 0}, {2, 3, 0}, {4, 0, 0}};
    EXPECT_EQ(distance_of_rows(straight, straight), 0);
    EXPECT_EQ(distance_of_rows(straight, peak), 3);
    EXPECT_EQ(distance_of_rows(peak, straight), 3);
    EXPECT_LT(length(nearest_on_row(peak, {2, 5, 0}) - Vec3{2, 3, 0}), 1e-12);
    EXPECT_LT(length(nearest_on_row(straight, {-1, 1, 0})), 1e-12);
}

}  // namespace
}  // namespace anatomesh::contour_loop_test
