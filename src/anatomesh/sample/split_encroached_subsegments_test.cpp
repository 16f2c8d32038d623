#include "anatomesh/sample/split_encroached_subsegments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace anatomesh::split_encroached_subsegments_test {
namespace {

struct Drawn {
    std::vector<Vec3> points;
    std::vector<Subsegment> subsegments;
    ProtectedSegments protected_segments{1, 100};

    std::uint32_t add(Vec3 p) {
        points.push_back(p);
        protected_segments.add_point(p);
        return static_cast<std::uint32_t>(points.size() - 1);
    }
    void join(std::uint32_t a, std::uint32_t b, std::uint32_t structures = 1) {
        const std::uint32_t ball = protected_segments.add_segment(points[a], points[b]);
        for (std::uint32_t s = 0; s < structures; ++s) subsegments.push_back({a, b, s, ball});
    }
};

// Segments from a pole, as planes about an axis draw them, with vertices at distances of their own.
Drawn pole(int rays) {
    Drawn drawn;
    const std::uint32_t centre = drawn.add({0, 0, 0});
    for (int k = 0; k < rays; ++k) {
        const double angle = 2 * std::numbers::pi * k / rays;
        std::uint32_t from = centre;
        double reach = 0.1 + std::fmod(0.37 * k, 0.9);
        for (int n = 0; n < 3; ++n, reach += 0.8) {
            const std::uint32_t to =
                drawn.add({reach * std::cos(angle), reach * std::sin(angle), -0.1 * reach * reach});
            drawn.join(from, to);
            from = to;
        }
    }
    return drawn;
}

std::size_t points_in_balls(const Drawn& drawn) {
    std::size_t count = 0;
    for (const Subsegment& subsegment : drawn.subsegments) {
        const Vec3 a = drawn.points[subsegment.a], b = drawn.points[subsegment.b];
        for (std::uint32_t v = 0; v < drawn.points.size(); ++v) {
            count += v != subsegment.a && v != subsegment.b &&
                     length(drawn.points[v] - 0.5 * (a + b)) < 0.499 * length(b - a);
        }
    }
    return count;
}

TEST(SplitEncroachedSubsegments, about_a_pole_every_subsegment_has_its_ball_for_itself) {
    for (const int rays : {6, 12, 26, 40}) {
        Drawn drawn = pole(rays);
        const std::vector<Vec3> before = drawn.points;
        const double whole = 3.0 * rays;
        EXPECT_EQ(static_cast<double>(drawn.subsegments.size()), whole);
        const std::size_t added = split_encroached_subsegments(drawn.points, drawn.subsegments,
                                                               drawn.protected_segments, {0.002, {}});
        EXPECT_EQ(drawn.points.size(), before.size() + added);
        EXPECT_EQ(drawn.subsegments.size(), static_cast<std::size_t>(whole) + added);
        EXPECT_EQ(points_in_balls(drawn), 0u) << rays;
        EXPECT_TRUE(std::equal(before.begin(), before.end(), drawn.points.begin()));
        EXPECT_LT(added, 30u * static_cast<std::size_t>(rays));
    }
}

// Drawn at distances of its own on either side of the pole. Were every other ray split, those between would
// have vertices in their balls for good, which lie nearer to each other than points may otherwise.
TEST(SplitEncroachedSubsegments,
     rays_nearer_to_each_other_than_points_may_lie_are_split_on_shells_side_by_side) {
    constexpr double shortest = 0.03;
    for (const int rays : {72, 120}) {
        for (const double bend : {0.0, 0.1}) {
            Drawn drawn;
            const std::uint32_t centre = drawn.add({0, 0, 0});
            for (int k = 0; k < rays; ++k) {
                const double angle = 2 * std::numbers::pi * k / rays;
                std::uint32_t from = centre;
                for (double reach = 2 * k < rays ? 0.18 : 1.32; reach < 4; reach += 1.5) {
                    const std::uint32_t to =
                        drawn.add({reach * std::cos(angle), reach * std::sin(angle), bend * reach * reach});
                    drawn.join(from, to);
                    from = to;
                }
            }
            split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments,
                                         {shortest, {}});
            // Left are some beside the shortest.
            EXPECT_LT(20 * points_in_balls(drawn), drawn.subsegments.size())
                << rays << " rays, bend " << bend;
        }
    }
}

TEST(SplitEncroachedSubsegments,
     no_subsegment_is_shorter_than_asked_and_no_point_nearer_than_half_of_it_but_on_its_shell) {
    const double shortest = 0.05;
    Drawn drawn = pole(26);
    const std::size_t first = drawn.points.size();
    split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments, {shortest, {}});
    ASSERT_GT(drawn.points.size(), first);
    for (std::size_t n = first; n < drawn.points.size(); ++n) {
        for (std::size_t m = 0; m < n; ++m) {
            if (ProtectedSegments::is_on_shell(drawn.points[m], drawn.points[n], drawn.points[0])) continue;
            EXPECT_GE(length(drawn.points[n] - drawn.points[m]), 0.5 * shortest);
        }
    }
}

TEST(SplitEncroachedSubsegments, segments_apart_stay_whole_and_shared_ones_are_split_for_all) {
    Drawn drawn;
    const auto a = drawn.add({0, 0, 0}), b = drawn.add({1, 0, 0}), c = drawn.add({0, 2, 0}),
               d = drawn.add({1, 2, 0});
    drawn.join(a, b, 2);
    drawn.join(c, d);
    EXPECT_EQ(
        split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments, {0.01, {}}),
        0u);
    EXPECT_EQ(drawn.subsegments.size(), 3u);
    drawn.add({0.5, 0.1, 0.2});
    EXPECT_EQ(
        split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments, {0.01, {}}),
        1u);
    EXPECT_EQ(points_in_balls(drawn), 0u);
    for (std::uint32_t s = 0; s < 2; ++s) {
        double whole = 0;
        for (const Subsegment& subsegment : drawn.subsegments) {
            if (subsegment.structure == s && drawn.points[subsegment.a].y < 1)
                whole += length(drawn.points[subsegment.b] - drawn.points[subsegment.a]);
        }
        EXPECT_NEAR(whole, 1, 1e-12) << s;
    }
}

// Lines of two structures that cross at small angles, and lines beside each other.
TEST(SplitEncroachedSubsegments, graded_are_no_longer_than_growth_times_the_distance_of_the_next_vertex) {
    constexpr double growth = 3, shortest = 0.004;
    for (const double degrees : {1.0, 3.0, 8.0, 20.0}) {
        for (const double apart : {0.0, 0.01, 0.03}) {
            SCOPED_TRACE(testing::Message() << degrees << " degrees, " << apart << " apart");
            Drawn drawn;
            const double angle = degrees * std::numbers::pi / 180;
            const auto a = drawn.add({0, 0, 0}), b = drawn.add({1, 0, 0}),
                       c = apart > 0 ? drawn.add({0.3, apart, 0}) : a,
                       d = drawn.add({1.1 * std::cos(angle), apart + 1.1 * std::sin(angle), 0});
            drawn.subsegments.push_back(
                {a, b, 0, drawn.protected_segments.add_segment(drawn.points[a], drawn.points[b])});
            drawn.subsegments.push_back(
                {c, d, 1, drawn.protected_segments.add_segment(drawn.points[c], drawn.points[d])});
            // As many as real slices have.
            std::vector<std::uint32_t> slices(drawn.points.size(), 0);
            for (int n = 0; n < 300; ++n) drawn.add({0.1 * n, 0, 5});
            slices.resize(drawn.points.size(), 1);
            split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments,
                                         {0.05, slices, growth, shortest});
            double whole[2] = {0, 0};
            for (const Subsegment& subsegment : drawn.subsegments) {
                const Vec3 p = drawn.points[subsegment.a], way = drawn.points[subsegment.b] - p;
                whole[subsegment.structure] += length(way);
                if (length(way) < 2 * shortest) continue;
                if (a == c && (subsegment.a == a || subsegment.b == a)) continue;
                for (const Subsegment& other : drawn.subsegments) {
                    const bool meet = other.a == subsegment.a || other.a == subsegment.b ||
                                      other.b == subsegment.a || other.b == subsegment.b;
                    if (other.structure == subsegment.structure || meet) continue;
                    for (const std::uint32_t v : {other.a, other.b}) {
                        const Vec3 q = drawn.points[v] - p;
                        const double share = std::clamp(dot(q, way) / squared_length(way), 0.0, 1.0);
                        EXPECT_LE(length(way), growth * length(q - share * way) * 1.0001);
                    }
                }
            }
            EXPECT_NEAR(whole[0], 1, 1e-9);
            EXPECT_NEAR(whole[1], length(drawn.points[d] - drawn.points[c]), 1e-9);
        }
    }
}

// Lines of two structures that cross at angles at which no length can follow the distance: vertices opposite
// each other leave every subsegment its ball.
TEST(SplitEncroachedSubsegments, graded_that_cross_at_small_angles_have_no_vertex_close_beside_them) {
    constexpr double growth = 3, shortest = 0.015;
    for (const double degrees : {0.3, 0.66, 1.0, 1.7, 3.3, 6.0}) {
        for (const double reach : {0.11, 0.4, 0.93}) {
            SCOPED_TRACE(testing::Message() << degrees << " degrees, ends at " << reach);
            Drawn drawn;
            const double angle = degrees * std::numbers::pi / 180;
            const auto centre = drawn.add({0, 0, 0});
            for (const double along : {1.0, -0.7, reach, -0.8 * reach}) {
                const bool level = along == 1.0 || along == -0.7;
                const auto end =
                    drawn.add(level ? Vec3{along, 0, 0} : along * Vec3{std::cos(angle), std::sin(angle), 0});
                const std::uint32_t ball =
                    drawn.protected_segments.add_segment(drawn.points[centre], drawn.points[end]);
                drawn.subsegments.push_back({centre, end, level ? 0u : 1u, ball});
            }
            std::vector<std::uint32_t> slices(drawn.points.size(), 0);
            for (int n = 0; n < 300; ++n) drawn.add({0.1 * n, 0, 5});
            slices.resize(drawn.points.size(), 1);
            split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments,
                                         {0.1, slices, growth, shortest});
            for (const Subsegment& subsegment : drawn.subsegments) {
                const Vec3 a = drawn.points[subsegment.a], way = drawn.points[subsegment.b] - a;
                for (std::uint32_t v = 0; v < drawn.points.size(); ++v) {
                    const Vec3 to = drawn.points[v] - a;
                    if (v == subsegment.a || v == subsegment.b || to.z != 0) continue;
                    const bool in_ball = length(to - 0.5 * way) < 0.4999 * length(way);
                    const double distance = length(cross(way, to)) / length(way);
                    EXPECT_FALSE(in_ball && growth * distance < length(way));
                }
            }
            for (std::size_t n = 0; n < drawn.points.size(); ++n) {
                for (std::size_t m = 0; m < n; ++m) EXPECT_NE(drawn.points[m], drawn.points[n]);
            }
            // As long as the angle lets them be.
            EXPECT_LE(drawn.subsegments.size(), 160u);
        }
    }
}

// Wedges of two structures in slices one above the other, whose vertices lie in each other's balls.
TEST(SplitEncroachedSubsegments, within_slices_only_what_strangers_of_the_slice_ask_for_is_split) {
    for (const double degrees : {4.0, 10.0, 25.0, 50.0}) {
        Drawn drawn;
        std::vector<std::uint32_t> slices, structures;
        const double angle = degrees * std::numbers::pi / 180;
        for (std::uint32_t slice = 0; slice < 4; ++slice) {
            const double z = 0.3 * slice;
            const auto apex = drawn.add({0, 0, z}), a = drawn.add({3, 0, z}),
                       b = drawn.add({2.7 * std::cos(angle), 2.7 * std::sin(angle), z}),
                       own = drawn.add({1.5, -0.2, z}), end = drawn.add({1.5, -3, z});
            for (const std::uint32_t v : {a, b}) {
                const std::uint32_t ball =
                    drawn.protected_segments.add_segment(drawn.points[apex], drawn.points[v]);
                drawn.subsegments.push_back({apex, v, v == b, ball});
            }
            drawn.subsegments.push_back(
                {own, end, 0, drawn.protected_segments.add_segment(drawn.points[own], drawn.points[end])});
            slices.insert(slices.end(), 5, slice);
        }
        split_encroached_subsegments(drawn.points, drawn.subsegments, drawn.protected_segments,
                                     {0.02, slices});
        // By slice the same.
        EXPECT_EQ(drawn.points.size() % 4, 0u) << degrees;
        for (const Subsegment& subsegment : drawn.subsegments) {
            const Vec3 p = drawn.points[subsegment.a], q = drawn.points[subsegment.b];
            for (const Subsegment& other : drawn.subsegments) {
                if (other.structure == subsegment.structure || drawn.points[other.a].z != p.z) continue;
                for (const std::uint32_t v : {other.a, other.b}) {
                    if (v == subsegment.a || v == subsegment.b) continue;
                    EXPECT_GE(length(drawn.points[v] - 0.5 * (p + q)), 0.4999 * length(q - p)) << degrees;
                }
            }
            // Nobody asked for these.
            if (p.y < 0) {
                EXPECT_NEAR(length(q - p), 2.8, 1e-12);
            }
        }
        EXPECT_LE(drawn.points.size(), 20u + 4u * 24u) << degrees;
    }
    Drawn apart;
    const auto a = apart.add({0, 0, 0}), b = apart.add({3, 0, 0}), c = apart.add({1.5, 0.2, 0.5}),
               d = apart.add({1.5, 3, 0.5}), e = apart.add({1.4, 0.3, 0}), f = apart.add({1.4, 3, 0});
    apart.join(a, b);
    apart.subsegments.push_back(
        {c, d, 1, apart.protected_segments.add_segment(apart.points[c], apart.points[d])});
    apart.join(e, f);
    EXPECT_EQ(split_encroached_subsegments(apart.points, apart.subsegments, apart.protected_segments,
                                           {0.02, {0, 0, 1, 1, 0, 0}}),
              0u);
}

}  // namespace
}  // namespace anatomesh::split_encroached_subsegments_test
