// warn_of_reconciling: warnings of the disagreements and movements that a user should know.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/compare/isolated_slices.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/slices/coverage/undrawn_structures.h"

namespace anatomesh {

// Ends that are nearer to their groups' points, across the contours, can be joined: nothing is left to move.
// [mm; > 0; M 2026-11, set not recorded]
inline constexpr double joinable_mm = 0.01;
// Shifts that grow by less have been found. [mm; > 0; B]
inline constexpr double align_precision_mm = 1e-3;

// Adds warnings W-RCN-001..013 from the statistics of reconcile_contours() for `set` as kept. There are
// none where no slices cross. All lengths are in mm; those that are told only beyond a number of working units
// (working_unit.h) go by `unit_mm`. O(pairs log pairs).
void warn_of_reconciling(const ContourSet& set, const ReconcileOptions& options, const ReconcileStats& stats,
                         std::span<const UndrawnStructure> undrawn, std::span<const IsolatedSlice> isolated,
                         double unit_mm, RunContext& context);

Place place_of_slice(const ContourSet& set, std::uint32_t slice, double value_mm);
std::string names_of(const ContourSet& set, std::uint32_t a, std::uint32_t b);

}  // namespace anatomesh
