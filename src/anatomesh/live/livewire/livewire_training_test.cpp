#include "anatomesh/live/livewire/livewire_training.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/livewire/livewire_path.h"
#include "anatomesh/live/livewire/livewire_pictures_for_test.h"

namespace anatomesh::livewire_training_test {
namespace {

using testing::costs_of;
using testing::features_of;
using testing::picture;

// Two edges beside each other, the weaker one bent as the stronger one; x of the weaker one at a height.
double weak_edge(double y) {
    return 40 + 6 * std::sin(0.03 * y);
}

constexpr double apart = 6;  // mm
constexpr double height = 300;

GreyPicture two_edges(unsigned seed, double noise = 4) {
    return picture(
        {{110, 301}, {1, 1}},
        [](Vec2 p) {
            const double from_weak = p.x - weak_edge(p.y);
            return from_weak < 0 ? 0.0 : from_weak < apart ? 40.0 : 160.0;
        },
        noise, seed);
}

// The share of points that are nearer to the weak edge than to the strong one.
double share_on_weak_edge(const std::vector<Vec2>& points) {
    std::size_t near = 0;
    for (const Vec2 p : points) near += p.x - weak_edge(p.y) < 0.5 * apart;
    return static_cast<double>(near) / static_cast<double>(points.size());
}

std::vector<Vec2> wire(const LivewireCosts& costs) {
    Livewire wire(costs);
    EXPECT_TRUE(wire.set_anchor({weak_edge(0), 0}).ok());
    return wire.line_to({weak_edge(height), height}).value().points;
}

// As a hand draws it: every 10 mm, a pixel aside in turns.
std::vector<Vec2> drawn_weak_edge(double length) {
    std::vector<Vec2> points;
    for (double y = 0; y <= length; y += 10) points.push_back({weak_edge(y) + std::sin(y), y});
    return points;
}

TEST(LivewireTraining, a_trained_wire_stays_on_the_weaker_edge_that_was_drawn) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const EdgeFeatures drawn_on = features_of(two_edges(seed)),
                           beside = features_of(two_edges(100 + seed));
        EXPECT_LT(share_on_weak_edge(wire(costs_of(beside))), 0.2) << seed;

        const std::vector<Vec2> points = drawn_weak_edge(100);
        const DrawnPath path{&drawn_on, points};
        const LivewireTraining training = train_livewire({&path, 1}).value();
        EXPECT_GT(training.places, 60u);
        // On the slice that was drawn on, and on the one beside it.
        EXPECT_GT(share_on_weak_edge(wire(costs_of(drawn_on, &training))), 0.98) << seed;
        EXPECT_GT(share_on_weak_edge(wire(costs_of(beside, &training))), 0.98) << seed;
    }
}

TEST(LivewireTraining, costs_least_what_was_seen_most) {
    const EdgeFeatures features = features_of(two_edges(1));
    const std::vector<Vec2> points = drawn_weak_edge(height);
    const DrawnPath path{&features, points};
    const LivewireTraining training = train_livewire({&path, 1}).value();
    // A step of 40 smoothed by 1.5 pixels rises by 10.6 per mm; the strong one by 32.
    EXPECT_LT(training.gradient.cost(10.6), 0.3);
    EXPECT_GT(training.gradient.cost(32), 0.99);
    EXPECT_GT(training.gradient.cost(1), 0.9);
    EXPECT_LT(training.bright.cost(42), 0.5);
    EXPECT_GT(training.bright.cost(160), 0.99);
    EXPECT_LT(training.dark.cost(1), 0.5);
    EXPECT_GT(training.dark.cost(-40), 0.99);
    EXPECT_LT(training.edge.cost(20), 0.4);
    for (const FeatureCost* cost : {&training.gradient, &training.edge, &training.bright, &training.dark}) {
        EXPECT_GT(*std::min_element(cost->costs.begin(), cost->costs.end()), 0);
        EXPECT_LE(*std::max_element(cost->costs.begin(), cost->costs.end()), 1);
        for (const double far : {cost->low - 1, cost->high + 1, std::nan("")}) EXPECT_EQ(cost->cost(far), 1);
    }
}

// Where there is one edge alone, training does no harm: the ring around a disc in noise stays as near to it.
TEST(LivewireTraining, a_trained_wire_follows_a_disc_as_well) {
    const PictureGrid grid{{96, 96}, {1, 1}};
    const double radius = 30;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const auto disc = [&](Vec2 centre, unsigned of_noise) {
            return features_of(picture(
                grid, [&](Vec2 p) { return 100 * testing::disc_share(p, centre, radius, grid.step); }, 20,
                of_noise));
        };
        const Vec2 centre{47 + 0.1 * seed, 48}, centre_beside{49, 46};
        const EdgeFeatures here = disc(centre, seed), beside = disc(centre_beside, 100 + seed);
        std::vector<Vec2> drawn;
        for (int n = 0; n < 24; ++n) {
            const double angle = n * std::numbers::pi / 12;
            drawn.push_back(centre_beside + radius * Vec2{std::cos(angle), std::sin(angle)});
        }
        const DrawnPath path{&beside, drawn, true};
        const LivewireTraining training = train_livewire({&path, 1}).value();
        const LivewireCosts costs = costs_of(here, &training);
        LivewirePath ring(costs);
        for (const Vec2 way : {Vec2{1, 0}, Vec2{0, 1}, Vec2{-1, 0}, Vec2{0, -1}})
            ASSERT_TRUE(ring.add_anchor(centre + radius * way).ok());
        const std::vector<Vec2> points = ring.ring().value();
        double distance = 0;
        for (const Vec2 p : points)
            distance += std::abs(length(p - centre) - radius) / static_cast<double>(points.size());
        EXPECT_LT(distance, 1) << seed;
        EXPECT_NEAR(std::abs(signed_area(points)) / (std::numbers::pi * radius * radius), 1, 0.015) << seed;
    }
}

// A path from several slices at once, and a path drawn the other way round, teach the same.
TEST(LivewireTraining, the_direction_of_drawing_does_not_matter) {
    const EdgeFeatures a = features_of(two_edges(1)), b = features_of(two_edges(2));
    std::vector<Vec2> points = drawn_weak_edge(height), reversed(points.rbegin(), points.rend());
    const std::vector<DrawnPath> forward{{&a, points}, {&b, points}}, back{{&a, reversed}, {&b, reversed}};
    const LivewireTraining one = train_livewire(forward).value(), other = train_livewire(back).value();
    EXPECT_NEAR(one.places, other.places, 10);
    for (const double gradient : {2.0, 8.0, 10.0, 12.0, 20.0})
        EXPECT_NEAR(one.gradient.cost(gradient), other.gradient.cost(gradient), 0.06);
}

TEST(LivewireTraining, a_ring_is_closed_and_a_line_is_not) {
    const PictureGrid grid{{60, 60}, {1, 1}};
    const EdgeFeatures features = features_of(picture(
        grid, [](Vec2 p) { return std::max(std::abs(p.x - 30), std::abs(p.y - 30)) < 15 ? 90.0 : 0; }));
    const std::vector<Vec2> square{{15, 15}, {45, 15}, {45, 45}, {15, 45}};
    const DrawnPath ring{&features, square, true}, line{&features, square, false};
    const std::uint32_t around = train_livewire({&ring, 1}).value().places;
    const std::uint32_t open = train_livewire({&line, 1}).value().places;
    EXPECT_NEAR(open, 0.75 * around, 0.05 * around);
}

TEST(LivewireTraining, one_grey_value_on_each_side_is_no_division_by_zero) {
    // Without noise or smoothing all places are equal.
    const PictureGrid grid{{40, 40}, {1, 1}};
    const EdgeFeatures features =
        features_of(picture(grid, [](Vec2 p) { return p.x < 20 ? 1.0 : 2.0; }), {.smoothing = 0});
    const std::vector<Vec2> points{{20, 0}, {20, 39}};
    const DrawnPath path{&features, points};
    const LivewireTraining training = train_livewire({&path, 1}).value();
    EXPECT_EQ(training.places, 40u);
    EXPECT_LT(training.gradient.cost(0.5), 0.03);
    EXPECT_EQ(training.gradient.cost(2), 1);
}

TEST(LivewireTraining, too_little_is_refused) {
    const EdgeFeatures features = features_of(two_edges(1));
    EXPECT_EQ(train_livewire({}).error().code, "E-LIV-108");
    const std::vector<Vec2> none, one{{40, 10}}, few{{40, 0}, {40, 8}}, outside{{-5, 0}, {-5, 300}};
    for (const std::vector<Vec2>& points : {none, one, few, outside}) {
        const DrawnPath path{&features, points, true};
        EXPECT_EQ(train_livewire({&path, 1}).error().code, "E-LIV-108");
    }
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        const std::vector<Vec2> points{{40, 0}, {40, bad}, {40, 300}};
        const DrawnPath path{&features, points};
        EXPECT_EQ(train_livewire({&path, 1}).error().code, "E-LIV-106");
        EXPECT_EQ(train_livewire({&path, 1}).error().place.contour, "point 1");
    }
    // A path through a constant picture shows no edge.
    const EdgeFeatures flat = features_of(picture({{50, 50}, {1, 1}}, [](Vec2) { return 3.0; }));
    const std::vector<Vec2> across{{0, 0}, {49, 49}};
    const DrawnPath path{&flat, across};
    EXPECT_EQ(train_livewire({&path, 1}).error().code, "E-LIV-108");
}

}  // namespace
}  // namespace anatomesh::livewire_training_test
