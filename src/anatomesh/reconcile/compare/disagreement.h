// How far crossing slices are from agreeing: figures per pair, the worst place, and what could be drawn back.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/reconcile/move/original_positions.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// One entry a pair of slices that has comparisons, in their order.
std::vector<PairDisagreement> disagreements(std::span<const LineComparison> comparisons);

// The order in which pairs of slices stand: by their slices.
bool is_pair_before(const PairDisagreement& p, const PairDisagreement& q);

// Fills the figures over all ends of all comparisons.
void summarize(std::span<const LineComparison> comparisons, ReconcileStats& stats);

// Fills how much the slices differ after reconciling, in all and by pair. `comparisons`: of the kept set.
void summarize_after(std::span<const LineComparison> comparisons, ReconcileStats& stats);

// Fills how far the drawn vertices moved, in all and by slice. O(points).
void summarize_movements(const ContourSet& set, const OriginalPositions& drawn, ReconcileStats& stats);

struct WorstPlace {
    std::uint32_t a = 0, b = 0, structure = 0;
    double distance_mm = 0;
    std::uint64_t places = 0;   // above the bound; pairs of slices, of worst_pair
    std::uint32_t culprit = 0;  // the slice with most of them
};

// The two slices that are furthest apart as a whole, if that is above the bound: by the median over the
// corresponding ends of a structure of their distance across the contours, that along the line times the
// lesser sine of the angles at which the contours meet the line.
std::optional<WorstPlace> worst_pair(const ContourSet& set, std::span<const LineComparison> comparisons,
                                     double bound_mm);

// The place where slices are furthest apart, if that is above the bound. Corresponding ends are as far apart
// as the nearer of the two is from the other slice's contour: where a contour runs nearly along the line, a
// small distance between contours is a large one along the line. What only one slice has counts by how far it
// would have to be drawn back, or, where it cannot be, by the depth of its middle.
std::optional<WorstPlace> worst_place(const ContourSet& set, std::span<const LineComparison> comparisons,
                                      double bound_mm);

}  // namespace anatomesh
