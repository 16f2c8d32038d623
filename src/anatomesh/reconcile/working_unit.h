// The unit of length that contours are reconciled in: 1 mm where slices and vertices are as far apart as on a patient,
// a power of two of that where they are not.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/walls/share_walls.h"
#include "anatomesh/reconcile/compare/reconcile_stats.h"
#include "anatomesh/slices/coverage/undrawn_structures.h"

namespace anatomesh {

// The geometric mean of two distances along and across the slices: of neighbouring vertices of a contour, and of
// planes (plane_spacings), which counts as no less than half and no more than 16 of the first. mm; 0 without contours.
// Complexity: that of plane_spacings.
double drawn_spacing(const ContourSet& set);

// Returns how many millimetres are one working unit: 1 where drawn_spacing() is from 1.25 to 5 mm, else the power of two
// that brings it between these, as near to 1 as there is. So tolerances are the same shares of what was drawn, within a
// factor of two, whatever its size. A power of two changes no bit but of exponents: of two sets beyond these spacings, one
// twice as large gives the same result, twice as large.
double working_unit_mm(const ContourSet& set);

// Returns the set with all lengths divided by the unit. O(points)
ContourSet in_units(ContourSet set, double unit_mm);
// The same of what is asked for in mm.
ReconcileOptions in_units(ReconcileOptions options, double unit_mm);

// Returns the options with the widths that differ from the usual ones: those are of the user, in mm; usual ones follow
// the distance of slices and vertices.
ReconcileOptions with_widths(ReconcileOptions options, const WallOptions& walls);

// Return all lengths multiplied by the unit, and areas by its square: the inverse of in_units(), bit for bit.
ContourSet in_mm(ContourSet set, double unit_mm);
ReconcileStats in_mm(ReconcileStats stats, double unit_mm);

}  // namespace anatomesh
