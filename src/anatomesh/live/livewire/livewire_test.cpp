#include "anatomesh/live/livewire/livewire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <numbers>

#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/livewire/livewire_path.h"
#include "anatomesh/live/livewire/livewire_pictures_for_test.h"
#include "anatomesh/live/livewire/smooth_line.h"

namespace anatomesh::livewire_test {
namespace {

using testing::costs_of;
using testing::features_of;
using testing::picture;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Vec2 random_point(const PictureGrid& grid, std::mt19937& random) {
    std::uniform_real_distribution<double> share(0, 1);
    return {share(random) * (grid.size[0] - 1) * grid.step.x,
            share(random) * (grid.size[1] - 1) * grid.step.y};
}

LivewireLine line(Livewire& wire, Vec2 pointer) {
    auto found = wire.line_to(pointer);
    EXPECT_TRUE(found.ok());
    return std::move(found).value();
}

// A bright disc in noise: SNR 5, four clicks beside its edge.
struct DiscCase {
    const char* name;
    Vec2 step;
    double turn;  // of the four anchors, in radians
};

class Disc : public ::testing::TestWithParam<DiscCase> {};

struct RingError {
    double area = 0, mean_distance = 0, largest_distance = 0;  // of the disc's area, in mean steps
};

RingError error_of(const std::vector<Vec2>& ring, Vec2 centre, double radius, double mean_step) {
    RingError error;
    error.area = std::abs(signed_area(ring)) / (std::numbers::pi * radius * radius) - 1;
    for (const Vec2 p : ring) {
        const double distance = std::abs(length(p - centre) - radius) / mean_step;
        error.mean_distance += distance / static_cast<double>(ring.size());
        error.largest_distance = std::max(error.largest_distance, distance);
    }
    return error;
}

std::vector<Vec2> ring_around(const LivewireCosts& costs, Vec2 centre, double radius, double turn) {
    LivewirePath path(costs);
    for (int n = 0; n < 4; ++n) {
        const double angle = turn + 0.5 * std::numbers::pi * n;
        EXPECT_TRUE(path.add_anchor(centre + radius * Vec2{std::cos(angle), std::sin(angle)}).ok());
    }
    return path.ring().value();
}

TEST_P(Disc, four_anchors_give_its_area_and_its_edge) {
    const DiscCase& disc = GetParam();
    const double mean_step = std::sqrt(disc.step.x * disc.step.y), radius = 30 * mean_step;
    const PictureGrid grid{{static_cast<std::uint32_t>(96 * mean_step / disc.step.x),
                            static_cast<std::uint32_t>(96 * mean_step / disc.step.y)},
                           disc.step};
    RingError worst;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Vec2 centre{(47 + 0.05 * seed) * mean_step, (48 - 0.04 * seed) * mean_step};
        GreyPicture slice = picture(
            grid, [&](Vec2 p) { return 100 * testing::disc_share(p, centre, radius, disc.step); }, 20, seed);
        slice.plane = make_plane({10, -20, 300}, {0.3, -0.8, 0.5});
        const std::vector<Vec2> ring = ring_around(costs_of(slice), centre, radius, disc.turn);
        const RingError error = error_of(ring, centre, radius, mean_step);
        EXPECT_LT(std::abs(error.area), 0.015) << seed;
        EXPECT_LT(error.mean_distance, 1) << seed;
        worst.area = std::max(worst.area, std::abs(error.area));
        worst.mean_distance = std::max(worst.mean_distance, error.mean_distance);
        worst.largest_distance = std::max(worst.largest_distance, error.largest_distance);

        const std::vector<Vec2> smooth = smooth_line(ring, true, disc.step);
        const RingError smooth_error = error_of(smooth, centre, radius, mean_step);
        EXPECT_LT(std::abs(smooth_error.area), 0.015) << seed;
        EXPECT_LT(smooth_error.mean_distance, error.mean_distance) << seed;

        // In space the ring lies on the slice's plane, as far from the disc's centre as in the plane.
        const Vec3 middle = slice.plane.to_space(centre);
        for (const Vec2 p : ring) {
            const Vec3 q = slice.plane.to_space(p);
            ASSERT_NEAR(length(q - middle), length(p - centre), 1e-9);
            ASSERT_NEAR(slice.plane.signed_distance(q), 0, 1e-9);
        }
    }
    RecordProperty("area", std::to_string(worst.area));
    RecordProperty("mean_distance", std::to_string(worst.mean_distance));
    RecordProperty("largest_distance", std::to_string(worst.largest_distance));
}

INSTANTIATE_TEST_SUITE_P(steps, Disc,
                         ::testing::Values(DiscCase{"equal", {1, 1}, 0},
                                           DiscCase{"equal_turned", {0.4, 0.4}, 0.6},
                                           DiscCase{"unequal", {0.5, 1.5}, 0},
                                           DiscCase{"unequal_turned", {1.5, 0.5}, 0.8}),
                         [](const auto& disc) { return std::string(disc.param.name); });

// Half a pixel is what a digital line needs: between steps along an axis and diagonal ones.
TEST(Livewire, is_straight_where_the_picture_is_constant) {
    std::mt19937 random(4);
    for (const Vec2 step : {Vec2{1, 1}, Vec2{0.5, 1.5}, Vec2{3, 0.7}}) {
        const PictureGrid grid{{70, 50}, step};
        const LivewireCosts costs = costs_of(picture(grid, [](Vec2) { return -1024.3; }));
        Livewire wire(costs);
        for (int n = 0; n < 100; ++n) {
            const Vec2 a = grid.position(wire.set_anchor(random_point(grid, random)).value().pixel);
            const Vec2 pointer = random_point(grid, random);
            const Vec2 b = grid.position(grid.nearest(pointer).pixel);
            for (const Vec2 p : line(wire, pointer).points) {
                if (a == b) continue;
                // Across the axis along which the line has more pixels, in pixels.
                const Vec2 along{(b - a).x / step.x, (b - a).y / step.y};
                const Vec2 here{(p - a).x / step.x, (p - a).y / step.y};
                const double most = std::max(std::abs(along.x), std::abs(along.y));
                EXPECT_LE(std::abs(cross(here, along)) / most, 0.5 + 1e-9);
            }
        }
    }
}

TEST(Livewire, starts_at_the_anchor_and_ends_at_the_pointer_through_neighbours) {
    std::mt19937 random(5);
    for (std::uint32_t n = 0; n < 40; ++n) {
        const PictureGrid grid{{40 + n, 90 - n}, {0.8, 1.1}};
        const LivewireCosts costs = costs_of(picture(
            grid, [](Vec2) { return 0.0; }, 1, unsigned(n)));
        Livewire wire(costs, {.window_pixels = 1, .margin = 1 + n});
        const Pixel anchor = wire.set_anchor(random_point(grid, random)).value().pixel;
        for (int query = 0; query < 5; ++query) {
            const Vec2 pointer = random_point(grid, random);
            const LivewireLine found = line(wire, pointer);
            ASSERT_EQ(found.points.front(), grid.position(anchor));
            ASSERT_EQ(found.points.back(), grid.position(grid.nearest(pointer).pixel));
            ASSERT_TRUE(found.inside);
            for (std::size_t v = 1; v < found.points.size(); ++v) {
                const Vec2 step = found.points[v] - found.points[v - 1];
                ASSERT_LE(std::abs(step.x), 1.01 * grid.step.x);
                ASSERT_LE(std::abs(step.y), 1.01 * grid.step.y);
            }
        }
    }
}

TEST(Livewire, is_that_of_the_whole_picture_where_it_says_so) {
    std::mt19937 random(6);
    int cheapest = 0, open = 0;
    for (int n = 0; n < 30; ++n) {
        const PictureGrid grid{{120, 110}, {1, 1}};
        const LivewireCosts costs = costs_of(picture(
            grid, [&](Vec2 p) { return 5 * std::sin(0.1 * p.x) * std::sin(0.07 * p.y * n); }, 1,
            unsigned(n)));
        Livewire near(costs, {.window_pixels = 1, .margin = 6}), whole(costs);
        const Vec2 anchor = random_point(grid, random);
        ASSERT_TRUE(near.set_anchor(anchor).ok() && whole.set_anchor(anchor).ok());
        for (int query = 0; query < 20; ++query) {
            const Vec2 pointer = random_point(grid, random);
            const LivewireLine a = line(near, pointer), b = line(whole, pointer);
            ASSERT_TRUE(b.cheapest);
            ASSERT_GE(a.cost_mm, b.cost_mm);
            cheapest += a.cheapest;
            open += !a.cheapest;
            if (!a.cheapest) continue;
            ASSERT_EQ(a.points, b.points);
            ASSERT_EQ(a.cost_mm, b.cost_mm);
        }
    }
    EXPECT_GT(cheapest, 100);
    EXPECT_GT(open, 50);
}

std::size_t area(const PixelWindow& window) {
    return std::size_t{window.right - window.left} * (window.bottom - window.top);
}

TEST(Livewire, the_window_has_the_pixels_that_may_be_searched_and_the_margin) {
    const PictureGrid grid{{600, 500}, {1, 1}};
    const LivewireCosts costs = costs_of(picture(
        grid, [](Vec2) { return 0.0; }, 1));
    std::mt19937 random(8);
    for (const std::uint32_t pixels : {1u, 5000u, 40000u, 300000u}) {
        Livewire wire(costs, {.window_pixels = pixels, .margin = 20});
        for (int n = 0; n < 40; ++n) {
            const Pixel a = wire.set_anchor(random_point(grid, random)).value().pixel;
            EXPECT_LE(area(wire.window()), std::max(pixels, 41u * 41u));
            const Vec2 pointer = random_point(grid, random);
            const LivewireLine found = line(wire, pointer);
            const Pixel b = grid.nearest(pointer).pixel;
            const PixelWindow needed{
                std::max(std::min(a.i, b.i), 10u) - 10, std::max(std::min(a.j, b.j), 10u) - 10,
                std::min(std::max(a.i, b.i) + 11, 600u), std::min(std::max(a.j, b.j) + 11, 500u)};
            EXPECT_TRUE(wire.window().contains(needed));
            EXPECT_TRUE(found.cheapest || pixels < grid.count());
            // What was asked for stays inside: nothing grows.
            const PixelWindow before = wire.window();
            line(wire, grid.position(a));
            line(wire, grid.position(b));
            EXPECT_EQ(wire.window(), before);
        }
    }
}

TEST(Livewire, work_ahead_changes_no_line) {
    std::mt19937 random(12);
    const PictureGrid grid{{90, 70}, {1, 1}};
    for (unsigned n = 0; n < 20; ++n) {
        const LivewireCosts costs = costs_of(picture(
            grid, [](Vec2 p) { return p.x; }, 5, n));
        const LivewireOptions small{.window_pixels = 1, .margin = 15};
        Livewire wire(costs, n % 2 ? small : LivewireOptions{}), ahead = wire;
        const Vec2 anchor = random_point(grid, random);
        ASSERT_TRUE(wire.set_anchor(anchor).ok() && ahead.set_anchor(anchor).ok());
        for (int query = 0; query < 20; ++query) {
            ahead.settle_ahead(static_cast<std::uint32_t>(random() % 900));
            const Vec2 pointer = random_point(grid, random);
            const LivewireLine a = line(wire, pointer), b = line(ahead, pointer);
            ASSERT_EQ(a.points, b.points);
            ASSERT_EQ(a.cheapest, b.cheapest);
        }
        EXPECT_TRUE(ahead.settle_ahead(90 * 70));
    }
}

TEST(Livewire, a_pointer_beyond_the_picture_leads_to_its_border_and_is_told) {
    const PictureGrid grid{{30, 20}, {0.5, 2}};
    const LivewireCosts costs = costs_of(picture(
        grid, [](Vec2) { return 0.0; }, 1));
    Livewire wire(costs);
    EXPECT_TRUE(wire.set_anchor({-0.25, 39}).value().inside);
    EXPECT_FALSE(wire.set_anchor({-0.26, 10}).value().inside);
    EXPECT_EQ(wire.set_anchor({-1e300, 10}).value().pixel, (Pixel{0, 5}));
    const LivewireLine found = line(wire, {1e300, -1e300});
    EXPECT_FALSE(found.inside);
    EXPECT_EQ(found.points.back(), grid.position({29, 0}));
    EXPECT_TRUE(line(wire, {14.75, 39}).inside);
    EXPECT_FALSE(line(wire, {14.75, 39.01}).inside);
}

TEST(Livewire, points_that_are_not_finite_are_refused_and_change_nothing) {
    const PictureGrid grid{{30, 20}, {1, 1}};
    const LivewireCosts costs = costs_of(picture(
        grid, [](Vec2) { return 0.0; }, 1));
    Livewire wire(costs);
    ASSERT_TRUE(wire.set_anchor({3, 4}).ok());
    const LivewireLine before = line(wire, {20, 10});
    for (const double bad : {not_a_number, std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(wire.set_anchor({bad, 1}).error().code, "E-LIV-106");
        EXPECT_EQ(wire.line_to({1, bad}).error().code, "E-LIV-106");
    }
    EXPECT_EQ(line(wire, {20, 10}).points, before.points);
}

// A wall of pixels without a value is passed at its gap; where it has none it is crossed all the same.
TEST(Livewire, pixels_without_a_value_cost_the_most_and_break_nothing) {
    for (const float bad :
         {std::nanf(""), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
        const PictureGrid grid{{60, 60}, {1, 1}};
        GreyPicture slice = picture(
            grid, [](Vec2 p) { return p.y < 30.5 ? 0.0 : 100.0; }, 5);
        // The edge runs along row 30; the wall covers all rows but those around it.
        for (std::uint32_t j = 0; j < 60; ++j) {
            if (j >= 28 && j <= 33) continue;
            for (std::uint32_t i = 25; i < 35; ++i) slice.pixels[grid.index({i, j})] = bad;
        }
        const LivewireCosts costs = costs_of(slice);
        Livewire wire(costs);
        ASSERT_TRUE(wire.set_anchor({5, 10}).ok());
        for (const Vec2 p : line(wire, {55, 50}).points) {
            if (p.x < 25 || p.x >= 35) continue;
            EXPECT_NEAR(p.y, 30.5, 2.6);
        }
        for (std::uint32_t j = 0; j < 60; ++j) slice.pixels[grid.index({30, j})] = bad;
        const LivewireCosts walled = costs_of(slice);
        Livewire through(walled);
        ASSERT_TRUE(through.set_anchor({5, 10}).ok());
        EXPECT_EQ(line(through, {55, 50}).points.back(), (Vec2{55, 50}));
        for (float& value : slice.pixels) value = bad;
        const LivewireCosts empty = costs_of(slice);
        Livewire lost(empty);
        ASSERT_TRUE(lost.set_anchor({5, 10}).ok());
        EXPECT_NEAR(line(lost, {55, 10}).cost_mm, 50, 0.01);
    }
}

TEST(Livewire, the_smallest_pictures_are_pictures) {
    for (const PictureGrid grid : {PictureGrid{{1, 1}, {1, 1}}, {{2, 1}, {0.1, 9}}, {{1, 3}, {1, 1}}}) {
        const LivewireCosts costs = costs_of(picture(grid, [](Vec2 p) { return p.x + p.y; }));
        Livewire wire(costs);
        ASSERT_TRUE(wire.set_anchor({0, 0}).ok());
        const LivewireLine found = line(wire, {100, 100});
        EXPECT_EQ(found.points.size(), grid.count());
        EXPECT_TRUE(found.cheapest);
    }
}

// Typically 1 ms; the bound is loose, since other programs run beside tests.
TEST(Livewire, answers_a_moving_pointer_in_time) {
    const PictureGrid grid{{512, 512}, {0.7, 0.7}};
    const LivewireCosts costs = costs_of(picture(
        grid, [](Vec2 p) { return 100 * std::sin(0.05 * p.x) * std::cos(0.04 * p.y); }, 20));
    Livewire wire(costs);
    std::mt19937 random(9);
    ASSERT_TRUE(wire.set_anchor(random_point(grid, random)).ok());
    std::vector<double> times;
    for (int n = 0; n < 200; ++n) {
        const Vec2 pointer = random_point(grid, random);
        const auto start = std::chrono::steady_clock::now();
        line(wire, pointer);
        times.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(times.begin(), times.end());
    EXPECT_LT(times[190], 100);
    RecordProperty("p95_ms", std::to_string(times[190]));
    RecordProperty("most_ms", std::to_string(times[199]));
}

}  // namespace
}  // namespace anatomesh::livewire_test
