#include "anatomesh/live/livewire/livewire_costs.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

// A thread takes so many pixels at a time. [pixels; >= 1; B]
constexpr std::size_t pixels_at_once = 16384;
// A right angle in the units of TurnAngle. [units; one value; D]
constexpr int quarter_turn = 16384;
// A straight angle in the same units. [units; one value; D]
constexpr int half_turn = 32768;

bool has_direction(PixelKind kind) {
    return kind == PixelKind::slope || kind == PixelKind::zero_crossing;
}

// Weights with a sum of 1; those of features that need training are 0 without it.
TrainedLivewireWeights normalized_weights(const LivewireTraining* training,
                                          const LivewireCostOptions& options) {
    TrainedLivewireWeights w = options.trained_weights;
    if (training == nullptr) {
        const LivewireWeights& plain = options.weights;
        w = {plain.zero_crossing, plain.gradient_direction, plain.gradient_magnitude, 0, 0, 0};
    }
    const std::array<double*, 6> all{&w.zero_crossing, &w.gradient_direction, &w.gradient_magnitude,
                                     &w.edge_value,    &w.bright_value,       &w.dark_value};
    double sum = 0;
    for (const double* const weight : all) {
        assert(*weight >= 0);
        sum += *weight;
    }
    assert(sum > 0 && std::isfinite(sum));
    for (double* const weight : all) *weight /= sum;
    return w;
}

// The weighted cost of the features that belong to a pixel: all but the direction.
class PixelCosts {
  public:
    PixelCosts(const EdgeFeatures& features, const LivewireTraining* training,
               const LivewireCostOptions& options)
        : features_(features), training_(training), weights_(normalized_weights(training, options)) {}

    double direction_weight() const { return weights_.gradient_direction; }

    // Requires: the pixel has a value.
    double cost(std::uint32_t v) const {
        const double cost = features_.kind[v] == PixelKind::zero_crossing ? 0 : weights_.zero_crossing;
        const double magnitude = features_.gradient_magnitude(v);
        if (training_ == nullptr) return cost + weights_.gradient_magnitude * weakness(magnitude);
        const EdgeFeatures::Sides sides = features_.sides(v);
        return cost + weights_.gradient_magnitude * training_->gradient.cost(magnitude) +
               weights_.edge_value * training_->edge.cost(features_.smoothed[v]) +
               weights_.bright_value * training_->bright.cost(sides.bright) +
               weights_.dark_value * training_->dark.cost(sides.dark);
    }

  private:
    double weakness(double magnitude) const {
        const double strong = features_.strong_gradient;
        return strong > 0 ? 1 - std::min(1.0, magnitude / strong) : 1;
    }

    const EdgeFeatures& features_;
    const LivewireTraining* training_;
    TrainedLivewireWeights weights_;
};

// How far a tangent turns from a step: 0 to a quarter turn, and whether it points forward or back along it.
struct Turn {
    int angle;
    bool forward;
};

Turn turn_between(TurnAngle tangent, TurnAngle step) {
    const int angle = std::abs(static_cast<int>(static_cast<std::int16_t>(tangent - step)));
    return angle <= quarter_turn ? Turn{angle, true} : Turn{half_turn - angle, false};
}

double direction_cost(const EdgeFeatures& features, std::uint32_t p, std::uint32_t q, TurnAngle step) {
    if (!has_direction(features.kind[p]) || !has_direction(features.kind[q])) return 1;
    const Turn at_p = turn_between(features.tangent[p], step), at_q = turn_between(features.tangent[q], step);
    if (at_p.forward != at_q.forward) return 1;
    return static_cast<double>(at_p.angle + at_q.angle) / half_turn;
}

// A direction to a later neighbour: its offset in pixels, its length and its angle in mm.
struct Step {
    int i, j;
    double length_mm;
    TurnAngle angle;
};

Step step_of(int i, int j, Vec2 step) {
    const Vec2 way{i * step.x, j * step.y};
    return {i, j, length(way), turn_angle(way)};
}

std::uint16_t rounded_cost(double cost) {
    return static_cast<std::uint16_t>(std::max(1.0, std::floor(cost + 0.5)));
}

}  // namespace

Result<LivewireCosts> make_livewire_costs(const EdgeFeatures& features, const LivewireTraining* training,
                                          const LivewireCostOptions& options, RunContext& context) {
    const PictureGrid& grid = features.grid;
    const std::size_t count = grid.count();
    const PixelCosts pixel_costs(features, training, options);
    std::vector<float> of_pixel(count);
    parallel_for(count, pixels_at_once, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end && !context.cancelled(); ++v) {
            if (features.kind[v] == PixelKind::no_value) continue;  // its steps cost the most anyway
            of_pixel[v] = static_cast<float>(pixel_costs.cost(static_cast<std::uint32_t>(v)));
        }
    });

    LivewireCosts costs{grid, std::vector<std::uint16_t>(step_directions * count, 0)};
    const std::array<Step, step_directions> steps{step_of(1, 0, grid.step), step_of(0, 1, grid.step),
                                                  step_of(1, 1, grid.step), step_of(-1, 1, grid.step)};
    const double unit = costs.mm_per_unit();
    const auto step_cost = [&](std::uint32_t v, const Step& step) -> std::uint16_t {
        const Pixel p = grid.pixel(v);
        const std::int64_t i = std::int64_t{p.i} + step.i, j = std::int64_t{p.j} + step.j;
        if (i < 0 || i >= grid.size[0] || j >= grid.size[1]) return 0;
        const std::uint32_t w = grid.index({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
        const bool known = features.kind[v] != PixelKind::no_value && features.kind[w] != PixelKind::no_value;
        const double per_mm =
            known ? 0.5 * (double{of_pixel[v]} + of_pixel[w]) +
                        pixel_costs.direction_weight() * direction_cost(features, v, w, step.angle)
                  : 1;
        return rounded_cost(std::min(per_mm, 1.0) * step.length_mm / unit);
    };
    parallel_for(count, pixels_at_once, context.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end && !context.cancelled(); ++v) {
            for (std::size_t d = 0; d < step_directions; ++d) {
                costs.steps[step_directions * v + d] = step_cost(static_cast<std::uint32_t>(v), steps[d]);
            }
        }
    });
    if (context.cancelled()) return cancelled_error();
    return costs;
}

}  // namespace anatomesh
