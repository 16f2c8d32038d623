// What the steps of reconcile_contours() hand on to each other.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/compare/isolated_slices.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/reconcile/move/original_positions.h"
#include "anatomesh/slices/coverage/undrawn_structures.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// What is found before anything moves, and stays as it is.
struct ReconcileScope {
    ReconcileOptions options;
    double unit_mm = 1;                     // what all lengths here and in the state are multiples of
    double margin_mm = 0;                   // how far beyond its own contours a slice says "outside"
    double clearance_mm = 0;                // of contours that are drawn back, from the other slice's plane
    std::vector<UndrawnStructure> undrawn;  // of these a slice says nothing, however the others come to lie
    std::vector<IsolatedSlice> isolated;
};

// What a step gets and returns. A step that does not help returns the state that it got.
struct ReconcileState {
    ContourSet set;
    OriginalPositions original;                                  // of the set's points
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // of slices whose planes cross, rising
    std::vector<LineComparison> comparisons;                     // of the set
    ReconcileStats stats;
};

// A step: a value in, a value out. Errors: those of the step.
using ReconcileStep = Result<ReconcileState>(ReconcileState state, const ReconcileScope& scope,
                                             RunContext& context);

// Compares the set's slices anew: gives the state its pairs and comparisons. Complexity: that of
// compare_planes.
void compare_slices(ReconcileState& state, const ReconcileScope& scope, RunContext& context);

// The comparisons of another set's slices, of the same pairs.
std::vector<LineComparison> comparisons_of(const ContourSet& set, const ReconcileState& state,
                                           const ReconcileScope& scope, RunContext& context);

// Gives the state the original positions of its points, of those that the state `before` had: the contours
// are the same, with points put in, moved or taken out.
void carry_over_original(ReconcileState& state, const ContourSet& before, const OriginalPositions& drawn);

// Puts the points in which slices agree into their contours. `state.original` is left as it was. The state is
// to be compared before.
void share_points(ReconcileState& state);

}  // namespace anatomesh
