// make_livewire_costs: what a step of a livewire from one pixel to the next costs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/live/livewire/livewire_training.h"

namespace anatomesh {

// Each weight is >= 0, and one is > 0; their sum counts as 1.
struct LivewireWeights {
    double zero_crossing = 0.43;
    double gradient_direction = 0.43;
    double gradient_magnitude = 0.14;
};

struct TrainedLivewireWeights {
    double zero_crossing = 0.3;
    double gradient_direction = 0.3;
    double gradient_magnitude = 0.1;
    double edge_value = 0.1;
    double bright_value = 0.1;
    double dark_value = 0.1;
};

struct LivewireCostOptions {
    LivewireWeights weights;  // without training; Mortensen and Barrett 1995
    TrainedLivewireWeights
        trained_weights;  // with training; measured on labels and drawn tumours of CT and MR
};

// A step at full cost over the longest way between neighbours, a diagonal, costs so much; all other costs are rounded to
// whole units of that. One less than a power of two, so that labels in a queue differ by less than that power.
// [units; 255 to 65535; D]
inline constexpr std::uint32_t most_step_cost = 16383;

// The four directions in which a pixel has a later neighbour: along the row, along the column, and both diagonals.
enum class StepDirection : std::uint8_t { right, down, down_right, down_left };
inline constexpr std::size_t step_directions = 4;  // their number [1; one value; D]

// The picture as an undirected graph, 8 neighbours each. Memory: 8 bytes for each pixel.
struct LivewireCosts {
    PictureGrid grid;
    // steps[step_directions * pixel + direction]: 1 to most_step_cost; 0 where the picture has no such neighbour.
    std::vector<std::uint16_t> steps;

    // A cost in these units is a length in mm, of a way that costs 1 per mm everywhere.
    double mm_per_unit() const { return length(grid.step) / most_step_cost; }
};

// A step from p to q costs |pq| in mm times a mean over the features of what they cost, each 0 to 1:
//   zero crossing       0 on one, else 1; the mean of both pixels;
//   gradient magnitude  1 - G / strong_gradient, at least 0; the mean of both pixels; trained: what training says of G;
//   gradient direction  the angles between the step and the tangents at p and q, over a half turn; 1 where the tangents
//                       point to opposite sides, or one pixel has none;
//   trained             of the grey values on the edge and on both sides of it; the mean of both pixels.
// A step from or to a pixel without a value costs 1 per mm, the most. Costs are the mean of those that the paper gives
// both directions, so that a path costs the same either way. Without `training` (null) no feature is trained.
// The result is the same for any number of threads. Errors: cancelled. Complexity: linear, parallel.
// Sources: Mortensen and Barrett, SIGGRAPH 1995, section 3.1; the same, GMIP 60, 1998.
Result<LivewireCosts> make_livewire_costs(const EdgeFeatures& features, const LivewireTraining* training,
                                          const LivewireCostOptions& options, RunContext& context);

}  // namespace anatomesh
