// crossing_report: what the report says of slices that cross.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh {

// Empty where no slices cross. `kept` and `stats`: of one reconcile_contours(). `reconciled`: whether
// contours were to move (ReconcileOptions::reconcile). Complexity: linear in pairs and slices.
CrossingReport crossing_report(const ContourSet& kept, const ReconcileStats& stats, bool reconciled);

}  // namespace anatomesh
