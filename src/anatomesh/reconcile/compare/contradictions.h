// Slices that contradict each other by more than contours may move.
#pragma once

#include <span>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/reconcile/move/original_positions.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Before contours are moved. Errors: geometry E-RCN-001 two slices are further apart than the bound, as a
// whole or so that a contour would have to move further; the worst are named, and what to do. O(ends).
Status check_bound(const ContourSet& set, std::span<const LineComparison> comparisons,
                   const ReconcileOptions& options);

// After that. Errors: geometry E-RCN-003 two slices still differ about a structure, by more than a tenth of
// the bound, although a contour of it in one of them moved by all of the bound within two bounds of the
// other's plane: to agree it would have to move further. The worst are named, and what to do. `drawn`: of the
// set's points. O(structures * (ends + pairs * points that moved so far)).
Status check_what_is_left(const ContourSet& set, const OriginalPositions& drawn,
                          std::span<const LineComparison> comparisons, const ReconcileOptions& options);

}  // namespace anatomesh
