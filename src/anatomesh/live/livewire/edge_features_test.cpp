#include "anatomesh/live/livewire/edge_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "anatomesh/live/livewire/livewire_pictures_for_test.h"

namespace anatomesh::edge_features_test {
namespace {

using testing::features_of;
using testing::picture;

double degrees(TurnAngle angle) {
    return angle * 360.0 / 65536;
}

double turned_by(TurnAngle angle, double expected_degrees) {
    return std::abs(std::remainder(degrees(angle) - expected_degrees, 360));
}

// The gradient of a plane is its slope per mm, whatever the steps, and the brighter side is on the tangent's right.
TEST(EdgeFeatures, gradients_are_per_mm_for_any_steps) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> slope(-20, 20);
    for (const Vec2 step : {Vec2{1, 1}, Vec2{0.5, 1.5}, Vec2{2, 0.3}, Vec2{0.05, 10}}) {
        for (int n = 0; n < 25; ++n) {
            const double x = slope(random), y = slope(random);
            const PictureGrid grid{{40, 40}, step};
            const EdgeFeatures features =
                features_of(picture(grid, [&](Vec2 p) { return 100 + x * p.x + y * p.y; }));
            // Away from the border, where the Gaussian is whole.
            const std::uint32_t middle = grid.index({20, 20});
            const int reach = int(std::ceil(3 * features.smoothing_mm / std::min(step.x, step.y)));
            if (reach < 19) {
                EXPECT_NEAR(features.gradient_x[middle], x, 0.01 + 1e-3 * std::abs(x));
                EXPECT_NEAR(features.gradient_y[middle], y, 0.01 + 1e-3 * std::abs(y));
                const double along = std::atan2(x, -y) * 180 / std::numbers::pi;
                EXPECT_LT(turned_by(features.tangent[middle], along), 0.1);
            }
        }
    }
}

TEST(EdgeFeatures, a_constant_picture_is_flat_exactly) {
    for (const double value : {0.0, 7.3, -1024.7, 1e30, 1e-30}) {
        for (const Vec2 step : {Vec2{1, 1}, Vec2{0.37, 1.91}}) {
            GreyPicture slice = picture({{37, 29}, step}, [&](Vec2) { return value; });
            slice.pixels[77] = std::nanf("");
            const EdgeFeatures features = features_of(slice);
            for (std::size_t v = 0; v < slice.pixels.size(); ++v)
                ASSERT_EQ(features.kind[v], v == 77 ? PixelKind::no_value : PixelKind::flat) << value;
            EXPECT_EQ(features.strong_gradient, 0);
        }
    }
}

// All strong zero crossings lie at the circle, and every point of the circle has one.
TEST(EdgeFeatures, zero_crossings_lie_on_the_edge) {
    for (const Vec2 step : {Vec2{1, 1}, Vec2{0.6, 1.3}}) {
        const PictureGrid grid{{101, 101}, step};
        const Vec2 centre = grid.position({50, 50});
        const double radius = 25;
        const GreyPicture slice =
            picture(grid, [&](Vec2 p) { return 100 * testing::disc_share(p, centre, radius, step); });
        const EdgeFeatures features = features_of(slice);
        std::vector<Vec2> crossings;
        for (std::uint32_t v = 0; v < grid.count(); ++v) {
            if (features.kind[v] != PixelKind::zero_crossing) continue;
            if (features.gradient_magnitude(v) < 0.1 * features.strong_gradient) continue;
            crossings.push_back(grid.position(grid.pixel(v)));
            const Vec2 offset = grid.position(grid.pixel(v)) - centre;
            EXPECT_NEAR(length(offset), radius, 0.75 * std::max(step.x, step.y));
            const Vec2 inwards{features.gradient_x[v], features.gradient_y[v]};
            EXPECT_LT(dot(inwards, offset), -0.95 * length(inwards) * length(offset));
        }
        for (int n = 0; n < 360; ++n) {
            const double angle = n * std::numbers::pi / 180;
            const Vec2 on_edge = centre + radius * Vec2{std::cos(angle), std::sin(angle)};
            double nearest = 1e9;
            for (const Vec2 p : crossings) nearest = std::min(nearest, length(p - on_edge));
            EXPECT_LT(nearest, std::max(step.x, step.y)) << n;
        }
    }
}

// Whatever value the others would have had: what is unknown makes no edge.
TEST(EdgeFeatures, pixels_without_a_value_make_no_edge) {
    const PictureGrid grid{{60, 40}, {1, 2}};
    for (const float bad :
         {std::nanf(""), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
        GreyPicture slice = picture(grid, [](Vec2) { return 50.0; });
        for (std::uint32_t j = 5; j < 20; ++j) {
            for (std::uint32_t i = 20; i < 60; ++i) slice.pixels[grid.index({i, j})] = bad;
        }
        const EdgeFeatures features = features_of(slice);
        for (std::uint32_t v = 0; v < grid.count(); ++v) {
            const bool known = std::isfinite(slice.pixels[v]);
            ASSERT_EQ(features.kind[v], known ? PixelKind::flat : PixelKind::no_value);
        }
    }
}

// An edge keeps its place in the scale when metal appears somewhere else.
TEST(EdgeFeatures, a_pixel_of_metal_does_not_change_what_a_strong_edge_is) {
    for (const double noise : {0.0, 10.0}) {
        for (const std::uint32_t side : {64u, 128u, 300u}) {
            const PictureGrid grid{{side, side}, {1, 1}};
            GreyPicture slice = picture(
                grid,
                [&](Vec2 p) {
                    return length(p - Vec2{0.4 * side, 0.4 * side}) < 0.2 * side ? 100.0 : 0;
                },
                noise);
            const double before = features_of(slice).strong_gradient;
            slice.pixels[grid.index({side - 12, side - 12})] = 1e6f;
            const double after = features_of(slice).strong_gradient;
            EXPECT_GT(before, 10);
            EXPECT_LT(after, 1.5 * before) << noise << " " << side;
        }
    }
}

// The largest floats beside each other, on the smallest pixels: gradients end at a bound, and nothing overflows.
TEST(EdgeFeatures, the_largest_values_have_finite_gradients) {
    constexpr float largest = std::numeric_limits<float>::max();
    for (const double step : {1e-6, 1.0, 1e7}) {
        std::mt19937 random(4);
        GreyPicture slice = picture({{30, 20}, {step, step}}, [](Vec2) { return 0.0; });
        for (float& value : slice.pixels) value = random() % 2 ? largest : -largest;
        const EdgeFeatures features = features_of(slice, {.smoothing = 0.5});
        EXPECT_TRUE(std::isfinite(features.strong_gradient));
        for (std::uint32_t v = 0; v < slice.pixels.size(); ++v) {
            ASSERT_TRUE(std::isfinite(features.gradient_magnitude(v)));
            const EdgeFeatures::Sides sides = features.sides(v);
            ASSERT_TRUE(features.kind[v] == PixelKind::flat || std::isfinite(sides.bright + sides.dark));
        }
        const std::vector<Vec2> points{{0, 0}, {29 * step, 19 * step}, {0, 19 * step}};
        const DrawnPath path{&features, points};
        const LivewireTraining training = train_livewire({&path, 1}).value();
        for (const std::uint16_t cost : testing::costs_of(features, &training).steps)
            ASSERT_LE(cost, most_step_cost);
    }
}

TEST(EdgeFeatures, are_the_same_for_any_number_of_threads) {
    const GreyPicture slice = picture(
        {{201, 333}, {1, 0.7}}, [](Vec2 p) { return p.x * p.y; }, 30);
    RunContext one, three;
    three.threads = 3;
    const EdgeFeatures a = find_edge_features(slice, {}, one).value();
    const EdgeFeatures b = find_edge_features(slice, {}, three).value();
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.smoothed, b.smoothed);
    EXPECT_EQ(a.gradient_x, b.gradient_x);
    EXPECT_EQ(a.gradient_y, b.gradient_y);
    EXPECT_EQ(a.tangent, b.tangent);
    EXPECT_EQ(a.strong_gradient, b.strong_gradient);
    LivewireCosts of_a = make_livewire_costs(a, nullptr, {}, one).value();
    EXPECT_EQ(of_a.steps, make_livewire_costs(b, nullptr, {}, three).value().steps);
}

TEST(EdgeFeatures, a_run_can_be_cancelled) {
    const GreyPicture slice = picture({{20, 20}, {1, 1}}, [](Vec2 p) { return p.x; });
    const EdgeFeatures features = features_of(slice);
    std::atomic<bool> stop = true;
    RunContext context;
    context.cancel = &stop;
    EXPECT_EQ(find_edge_features(slice, {}, context).error().code, "E-RUN-001");
    EXPECT_EQ(make_livewire_costs(features, nullptr, {}, context).error().code, "E-RUN-001");
}

// A thin band of pixels is looked at on both sides without leaving the picture.
TEST(EdgeFeatures, sides_are_the_brighter_and_the_darker_one) {
    const PictureGrid grid{{60, 12}, {1, 2}};
    for (const double sign : {1.0, -1.0}) {
        const EdgeFeatures features =
            features_of(picture(grid, [&](Vec2 p) { return p.x < 29.5 ? 20 : 20 + sign * 80; }));
        const EdgeFeatures::Sides sides = features.sides(grid.index({29, 0}));
        EXPECT_NEAR(sides.bright, sign > 0 ? 100 : 20, 5);
        EXPECT_NEAR(sides.dark, sign > 0 ? 20 : -60, 5);
        EXPECT_TRUE(std::isnan(features.sides(grid.index({5, 5})).bright));
    }
}

std::string code_of(const GreyPicture& slice) {
    RunContext context;
    const auto features = find_edge_features(slice, {}, context);
    EXPECT_EQ(features.ok(), check_grey_picture(slice).ok());
    if (features.ok()) return "";
    EXPECT_EQ(features.error().place.file, "picture");
    EXPECT_FALSE(features.error().next_step.empty());
    return features.error().code;
}

TEST(GreyPicture, what_is_no_picture_is_refused) {
    const GreyPicture good = picture({{6, 5}, {1, 1}}, [](Vec2 p) { return p.x; });
    EXPECT_EQ(code_of(good), "");
    for (const auto& size : {std::array<std::uint32_t, 2>{0, 5}, {6, 0}, {0, 0}}) {
        GreyPicture slice = good;
        slice.grid.size = size;
        slice.pixels.clear();
        EXPECT_EQ(code_of(slice), "E-LIV-101");
    }
    // The values are not looked at, and nothing is allocated for them.
    for (const auto& size : {std::array<std::uint32_t, 2>{most_pixels_of_side + 1, 1},
                             {1, 0xFFFFFFFF},
                             {0xFFFFFFFF, 0xFFFFFFFF},
                             {most_pixels_of_side, most_pixels_of_side}}) {
        GreyPicture slice = good;
        slice.grid.size = size;
        EXPECT_EQ(code_of(slice), "E-LIV-102");
        EXPECT_EQ(check_grey_picture(slice).error().kind, ErrorKind::limit);
    }
    constexpr double infinite = std::numeric_limits<double>::infinity();
    for (const double step :
         {0.0, -1.0, infinite, -infinite, std::nan(""), 1e-300, 1e300, 201.0, 1 / 201.0}) {
        GreyPicture slice = good;
        slice.grid.step = {step, 1};
        EXPECT_EQ(code_of(slice), "E-LIV-103") << step;
        slice.grid.step = {1, step};
        EXPECT_EQ(code_of(slice), "E-LIV-103") << step;
    }
    for (const std::size_t count : {0u, 29u, 31u}) {
        GreyPicture slice = good;
        slice.pixels.resize(count);
        EXPECT_EQ(code_of(slice), "E-LIV-104");
    }
    std::vector<Plane> planes(6);
    planes[0].u = {0, 0, 0};
    planes[1].v = {0.1, 1, 0};
    planes[2].normal = {0, 0, -1};
    planes[3].origin = {0, infinite, 0};
    planes[4].u = {std::nan(""), 0, 0};
    planes[5].v = {0, 2, 0};
    for (const Plane& plane : planes) {
        GreyPicture slice = good;
        slice.plane = plane;
        EXPECT_EQ(code_of(slice), "E-LIV-105");
    }
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 300; ++n) {
        GreyPicture slice = good;
        slice.plane = make_plane({1e6, -1e6, 5}, {normal(random), normal(random), normal(random)});
        EXPECT_EQ(code_of(slice), "");
    }
}

}  // namespace
}  // namespace anatomesh::edge_features_test
