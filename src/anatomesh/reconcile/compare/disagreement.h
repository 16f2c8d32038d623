// disagreements: how far crossing slices are from agreeing, by pair of slices, in all, and at the worst
// place.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/reconcile/move/original_positions.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Returns one entry for each pair of slices that has comparisons, in their order. O(endpoints log endpoints).
std::vector<PairDisagreement> disagreements(std::span<const LineComparison> comparisons);

// Pairs of slices stand in the order of their slices.
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

// Returns the two slices that are furthest apart as a whole, if that is above the bound. They are as far
// apart as the corresponding endpoints of a structure are in the median, across the contours. That is the
// distance along the line times the lesser sine of the angles at which the contours meet it.
std::optional<WorstPlace> worst_pair(const ContourSet& set, std::span<const LineComparison> comparisons,
                                     double bound_mm);

// Returns the place where slices are furthest apart, if that is above the bound. Corresponding endpoints are
// as far apart as the nearer of the two is from the other slice's contour. A contour that runs nearly along
// the line would make a small distance a large one. What only one slice has counts by how far it would have
// to be drawn back. Where it cannot be, it counts by the depth of its middle.
std::optional<WorstPlace> worst_place(const ContourSet& set, std::span<const LineComparison> comparisons,
                                      double bound_mm);

}  // namespace anatomesh
