// train_livewire: learns from drawn paths what the edge that the user follows looks like.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/live/livewire/edge_features.h"

namespace anatomesh {

// A path or ring that the user accepted, on its own slice or on one beside it.
struct DrawnPath {
    const EdgeFeatures* features = nullptr;  // of the slice that it was drawn on
    std::span<const Vec2> points;            // mm, in that slice's plane; finite
    bool closed = false;                     // the last point is joined to the first
};

struct LivewireTrainingOptions {
    // A drawn point may lie beside its edge: the strongest gradient within this distance counts, in mean pixel steps.
    // [0, 5]
    double snap = 1.5;
};

// The cost of a value of one feature: how likely a pixel with that value lies beside a drawn edge and not on it. 0: it is
// on the edge for sure; 1: drawn edges never have it.
struct FeatureCost {
    double low = 0, high = 0;  // of the values that were seen, and what may be taken for them
    std::vector<float> costs;  // of equal parts of [low, high); empty: every value costs 0
    double cost(double value) const;
};

// What was learnt: the dynamic features of Mortensen and Barrett 1998.
struct LivewireTraining {
    FeatureCost gradient;      // gradient magnitude, grey values per mm
    FeatureCost edge;          // grey value on the edge
    FeatureCost bright, dark;  // grey values on the two sides of it
    std::uint32_t places = 0;  // that it was learnt from
};

// Looks at each pixel that the paths lead through (moved to the strongest gradient nearby), and at pixels 3 to 9 steps
// beside it. Both give a histogram of each feature, smoothed by a Gaussian (Silverman's width); the cost is the share of
// the second in their sum. Sides are told apart by their brightness, so a path may be drawn in either direction. Values
// are absolute: slices need the same grey scale.
// Errors: input E-LIV-106 a point is not finite; input E-LIV-108 the paths lead through fewer than 16 pixels with an edge.
// Complexity: linear in the paths' lengths in pixels. Requires: features of every path.
// Sources: Mortensen and Barrett, GMIP 60, 1998 (features, histograms). There the cost is the first histogram turned over;
// beside it grey values of the surroundings, which drawn edges have too, lead the wire into short cuts.
Result<LivewireTraining> train_livewire(std::span<const DrawnPath> paths,
                                        const LivewireTrainingOptions& options = {});

}  // namespace anatomesh
