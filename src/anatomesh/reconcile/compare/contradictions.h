// check_bound, check_what_is_left: slices that contradict each other by more than contours may move are
// refused.
#pragma once

#include <span>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/reconcile/move/original_positions.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// Checks the bound before contours move. Errors: geometry E-RCN-001 two slices are further apart than the
// bound, as a whole or at a place to which a contour would have to move further. The error names the worst
// slices and what to do, with lengths in mm: `unit_mm` is what the set and the bound are multiples of. O(endpoints).
Status check_bound(const ContourSet& set, std::span<const LineComparison> comparisons,
                   const ReconcileOptions& options, double unit_mm);

// Checks the bound after contours moved. Errors: geometry E-RCN-003 two slices still differ about a
// structure by more than a tenth of the bound, although one of its contours moved by all of the bound.
// Only points within two bounds of the other slice's plane count. To agree, the contour would have to move
// further. The error names the worst slices and what to do. `drawn`: of the set's points. O(structures *
// (endpoints + pairs * points that moved so far)).
Status check_what_is_left(const ContourSet& set, const OriginalPositions& drawn,
                          std::span<const LineComparison> comparisons, const ReconcileOptions& options,
                          double unit_mm);

}  // namespace anatomesh
