// Slices that contradict each other by more than contours may move.
#pragma once

#include <span>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/contour_set.h"
#include "anatomesh/reconcile/line_ends.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh {

// Before contours are moved. Errors: geometry E-RCN-001 two slices are further apart than the bound, as a
// whole or so that a contour would have to move further; the worst are named, and what to do. O(ends).
Status check_bound(const ContourSet& set, std::span<const LineComparison> comparisons,
                   const ReconcileOptions& options);

// After that; `movements` by slice. Errors: geometry E-RCN-003 two slices still differ, by more than a tenth
// of the bound, although a contour of theirs moved by all of it: to agree it would have to move further. The
// worst are named, and what to do. O(pairs).
Status check_what_is_left(const ContourSet& set, std::span<const LineComparison> comparisons,
                          std::span<const SliceMovement> movements, const ReconcileOptions& options);

}  // namespace anatomesh
