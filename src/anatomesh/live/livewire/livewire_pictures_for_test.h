// Pictures of known shape, with noise, for the tests of livewires.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "anatomesh/live/livewire/livewire_costs.h"

namespace anatomesh::testing {

// A picture of a function of the position in mm, with normal noise of this standard deviation.
template <class Value>
GreyPicture picture(PictureGrid grid, const Value& value, double noise = 0, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    GreyPicture slice;
    slice.grid = grid;
    slice.source = "picture";
    for (std::uint32_t j = 0; j < grid.size[1]; ++j) {
        for (std::uint32_t i = 0; i < grid.size[0]; ++i) {
            const double grey = value(grid.position({i, j})) + (noise > 0 ? noise * normal(random) : 0);
            slice.pixels.push_back(static_cast<float>(grey));
        }
    }
    return slice;
}

// How much of a pixel around p a disc covers, of 8 x 8 samples: what a scanner sees of its edge.
inline double disc_share(Vec2 p, Vec2 centre, double radius, Vec2 step) {
    int inside = 0;
    for (int n = 0; n < 64; ++n) {
        const Vec2 sample{p.x + ((n % 8 + 0.5) / 8 - 0.5) * step.x, p.y + ((n / 8 + 0.5) / 8 - 0.5) * step.y};
        inside += length(sample - centre) <= radius;
    }
    return inside / 64.0;
}

inline EdgeFeatures features_of(const GreyPicture& slice, const EdgeFeatureOptions& options = {}) {
    RunContext context;
    return find_edge_features(slice, options, context).value();
}

inline LivewireCosts costs_of(const EdgeFeatures& features, const LivewireTraining* training = nullptr) {
    RunContext context;
    return make_livewire_costs(features, training, {}, context).value();
}

inline LivewireCosts costs_of(const GreyPicture& slice) {
    return costs_of(features_of(slice));
}

// Costs that are random numbers, small ones so that many paths are equally cheap where `most` is small.
inline LivewireCosts random_costs(PictureGrid grid, std::uint32_t most, std::mt19937& random) {
    LivewireCosts costs{grid, std::vector<std::uint16_t>(step_directions * grid.count(), 0)};
    for (std::uint32_t v = 0; v < grid.count(); ++v) {
        const Pixel p = grid.pixel(v);
        const bool right = p.i + 1 < grid.size[0], down = p.j + 1 < grid.size[1];
        const bool present[step_directions] = {right, down, right && down, p.i > 0 && down};
        for (std::size_t d = 0; d < step_directions; ++d) {
            if (present[d])
                costs.steps[step_directions * v + d] = static_cast<std::uint16_t>(1 + random() % most);
        }
    }
    return costs;
}

}  // namespace anatomesh::testing
