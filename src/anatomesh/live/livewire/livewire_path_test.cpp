#include "anatomesh/live/livewire/livewire_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "anatomesh/live/livewire/livewire_pictures_for_test.h"
#include "anatomesh/live/livewire/smooth_line.h"

namespace anatomesh::livewire_path_test {
namespace {

using testing::costs_of;
using testing::picture;

LivewireCosts noisy_costs(unsigned seed) {
    return costs_of(picture(
        {{80, 60}, {0.5, 1}}, [](Vec2 p) { return 20 * std::sin(0.3 * p.x); }, 5, seed));
}

Vec2 random_point(std::mt19937& random) {
    return {0.5 * static_cast<double>(random() % 80), static_cast<double>(random() % 60)};
}

TEST(LivewirePath, five_clicks_back_twice_two_clicks_back_until_none_and_a_click) {
    const LivewireCosts costs = noisy_costs(1);
    LivewirePath path(costs);
    std::mt19937 random(1);
    std::vector<std::size_t> states;
    const auto click = [&](int times) {
        for (int n = 0; n < times; ++n) ASSERT_TRUE(path.add_anchor(random_point(random)).ok());
        states.push_back(path.anchors().size());
    };
    click(5);
    EXPECT_TRUE(path.step_back() && path.step_back());
    states.push_back(path.anchors().size());
    click(2);
    while (path.step_back()) {
    }
    states.push_back(path.anchors().size());
    EXPECT_TRUE(path.frozen().empty());
    EXPECT_FALSE(path.step_back());
    ASSERT_TRUE(path.add_anchor({3, 7}).ok());
    states.push_back(path.anchors().size());
    EXPECT_EQ(states, (std::vector<std::size_t>{5, 3, 5, 0, 1}));
    EXPECT_EQ(path.frozen(), (std::vector<Vec2>{{3, 7}}));
    EXPECT_EQ(path.line_to({20, 30}).value().points.front(), (Vec2{3, 7}));
}

// Random clicks, steps back and straight segments, beside a list of what must be there.
TEST(LivewirePath, a_step_back_restores_what_was_there_before_the_click) {
    std::mt19937 random(2);
    for (unsigned seed = 0; seed < 25; ++seed) {
        const LivewireCosts costs = noisy_costs(seed);
        LivewirePath path(costs);
        struct Before {
            std::vector<Vec2> frozen, anchors;
            std::optional<Vec2> pointer;
            std::vector<Vec2> live;
        };
        std::vector<Before> states;
        for (int turn = 0; turn < 40; ++turn) {
            if (random() % 3 > 0 || states.empty()) {
                Before before{path.frozen(), path.anchors(), {}, {}};
                if (!path.anchors().empty()) {
                    before.pointer = random_point(random);
                    before.live = path.line_to(*before.pointer).value().points;
                }
                states.push_back(before);
                const auto segment =
                    random() % 4 == 0 ? LivewireSegment::straight : LivewireSegment::along_edges;
                ASSERT_TRUE(path.add_anchor(random_point(random), segment).ok());
            } else {
                const Before& before = states.back();
                ASSERT_TRUE(path.step_back());
                ASSERT_EQ(path.frozen(), before.frozen);
                ASSERT_EQ(path.anchors(), before.anchors);
                if (before.pointer) {
                    ASSERT_EQ(path.line_to(*before.pointer).value().points, before.live);
                }
                states.pop_back();
            }
            ASSERT_EQ(path.anchors().size(), states.size());
        }
    }
}

TEST(LivewirePath, a_click_freezes_the_line_that_was_shown) {
    std::mt19937 random(3);
    const LivewireCosts costs = noisy_costs(3);
    LivewirePath path(costs);
    ASSERT_TRUE(path.add_anchor(random_point(random)).ok());
    for (int n = 0; n < 30; ++n) {
        for (int move = 0; move < 3; ++move) ASSERT_TRUE(path.line_to(random_point(random)).ok());
        const Vec2 click = random_point(random);
        std::vector<Vec2> expected = path.frozen();
        const std::vector<Vec2> live = path.line_to(click).value().points;
        ASSERT_EQ(live.front(), expected.back());
        expected.insert(expected.end(), live.begin() + 1, live.end());
        ASSERT_TRUE(path.add_anchor(click).ok());
        ASSERT_EQ(path.frozen(), expected);
        ASSERT_EQ(path.anchors().back(), click);
    }
}

TEST(LivewirePath, straight_segments_go_straight_and_others_along_edges) {
    const LivewireCosts costs = noisy_costs(4);
    LivewirePath path(costs);
    ASSERT_TRUE(path.add_anchor({2, 3}).ok());
    const LivewireLine straight = path.line_to({20.1, 40.2}, LivewireSegment::straight).value();
    EXPECT_EQ(straight.points, (std::vector<Vec2>{{2, 3}, {20, 40}}));
    EXPECT_FALSE(straight.cheapest);
    EXPECT_EQ(path.line_to({2, 3}, LivewireSegment::straight).value().points.size(), 1u);
    EXPECT_FALSE(path.line_to({1e9, 3}, LivewireSegment::straight).value().inside);
    ASSERT_TRUE(path.add_anchor({20, 40}, LivewireSegment::straight).ok());
    EXPECT_EQ(path.frozen(), (std::vector<Vec2>{{2, 3}, {20, 40}}));
    ASSERT_TRUE(path.add_anchor({30, 10}).ok());
    EXPECT_GT(path.frozen().size(), 20u);
}

TEST(LivewirePath, a_ring_comes_back_to_its_first_anchor_without_repeating_it) {
    std::mt19937 random(5);
    for (unsigned seed = 0; seed < 40; ++seed) {
        const LivewireCosts costs = noisy_costs(seed);
        LivewirePath path(costs);
        const std::size_t anchors = 2 + random() % 5;
        for (std::size_t n = 0; n < anchors; ++n) ASSERT_TRUE(path.add_anchor(random_point(random)).ok());
        std::vector<Vec2> more;
        if (seed % 2) more.push_back(path.anchors().back());        // a double click
        if (seed % 3 == 0) more.push_back(path.anchors().front());  // closed by hand
        for (const Vec2 click : more) ASSERT_TRUE(path.add_anchor(click).ok());
        const std::vector<Vec2> frozen = path.frozen();
        const auto ring = path.ring();
        if (!ring.ok()) {
            EXPECT_EQ(ring.error().code, "E-LIV-107");
            continue;
        }
        const std::vector<Vec2>& points = ring.value();
        ASSERT_EQ(points.front(), path.anchors().front());
        ASSERT_FALSE(points.back() == points.front());
        for (std::size_t v = 0; v < points.size(); ++v) {
            const Vec2 step = points[(v + 1) % points.size()] - points[v];
            ASSERT_FALSE(step == Vec2{});
            ASSERT_LE(std::abs(step.x), 0.5 + 1e-9);
            ASSERT_LE(std::abs(step.y), 1 + 1e-9);
        }
        for (const Vec2 anchor : path.anchors())
            ASSERT_NE(std::find(points.begin(), points.end(), anchor), points.end());
        ASSERT_EQ(path.frozen(), frozen);
    }
}

TEST(LivewirePath, what_is_no_ring_is_refused) {
    const LivewireCosts costs = noisy_costs(6);
    LivewirePath path(costs);
    EXPECT_EQ(path.ring().error().code, "E-LIV-107");
    ASSERT_TRUE(path.add_anchor({2, 3}).ok());
    EXPECT_EQ(path.ring().error().code, "E-LIV-107");
    ASSERT_TRUE(path.add_anchor({2, 3}).ok());
    EXPECT_EQ(path.ring().error().code, "E-LIV-107");
    ASSERT_TRUE(path.add_anchor({20, 40}, LivewireSegment::straight).ok());
    EXPECT_EQ(path.ring(LivewireSegment::straight).error().code, "E-LIV-107");
    EXPECT_TRUE(path.ring().ok());
}

TEST(LivewirePath, points_that_are_not_finite_change_nothing) {
    const LivewireCosts costs = noisy_costs(7);
    LivewirePath path(costs);
    const double bad = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(path.add_anchor({bad, 0}).error().code, "E-LIV-106");
    EXPECT_TRUE(path.anchors().empty());
    ASSERT_TRUE(path.add_anchor({2, 3}).ok());
    for (const LivewireSegment segment : {LivewireSegment::straight, LivewireSegment::along_edges}) {
        EXPECT_EQ(path.add_anchor({0, bad}, segment).error().code, "E-LIV-106");
        EXPECT_EQ(path.line_to({0, bad}, segment).error().code, "E-LIV-106");
    }
    EXPECT_EQ(path.frozen(), (std::vector<Vec2>{{2, 3}}));
    EXPECT_FALSE(path.add_anchor({1000, 3}).value().inside);
    EXPECT_EQ(path.anchors().back(), (Vec2{39.5, 3}));
}

TEST(LivewirePath, other_costs_lead_the_next_lines_and_leave_the_frozen_ones) {
    const LivewireCosts first = noisy_costs(8), second = noisy_costs(9);
    LivewirePath path(first);
    ASSERT_TRUE(path.add_anchor({2, 3}).ok() && path.add_anchor({30, 20}).ok());
    const std::vector<Vec2> frozen = path.frozen();
    const std::vector<Vec2> before = path.line_to({5, 50}).value().points;
    path.set_costs(second);
    EXPECT_EQ(path.frozen(), frozen);
    const std::vector<Vec2> after = path.line_to({5, 50}).value().points;
    EXPECT_EQ(after.front(), before.front());
    EXPECT_NE(after, before);
    Livewire wire(second);
    ASSERT_TRUE(wire.set_anchor({30, 20}).ok());
    EXPECT_EQ(after, wire.line_to({5, 50}).value().points);
}

TEST(SmoothLine, leaves_no_pixel_and_keeps_the_ends) {
    std::mt19937 random(10);
    for (unsigned seed = 0; seed < 30; ++seed) {
        const LivewireCosts costs = noisy_costs(seed);
        LivewirePath path(costs);
        for (int n = 0; n < 4; ++n) ASSERT_TRUE(path.add_anchor(random_point(random)).ok());
        const std::vector<Vec2> line = path.frozen(), ring = path.ring().value();
        const std::vector<Vec2> smooth = smooth_line(line, false, costs.grid.step);
        ASSERT_EQ(smooth.front(), line.front());
        ASSERT_EQ(smooth.back(), line.back());
        const auto expect_within = [&](const std::vector<Vec2>& moved, const std::vector<Vec2>& points) {
            ASSERT_EQ(moved.size(), points.size());
            for (std::size_t v = 0; v < points.size(); ++v) {
                ASSERT_LE(std::abs(moved[v].x - points[v].x), 0.25 + 1e-12);
                ASSERT_LE(std::abs(moved[v].y - points[v].y), 0.5 + 1e-12);
            }
        };
        expect_within(smooth, line);
        expect_within(smooth_line(ring, true, costs.grid.step), ring);
    }
    for (const std::size_t count : {0u, 1u, 2u}) {
        const std::vector<Vec2> few(count, Vec2{1, 2});
        EXPECT_EQ(smooth_line(few, true, {1, 1}), few);
    }
}

}  // namespace
}  // namespace anatomesh::livewire_path_test
