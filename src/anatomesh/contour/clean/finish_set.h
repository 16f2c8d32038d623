// The last steps of clean_contours(), which see the contours of all slices and structures at once.
#pragma once

#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/clean/reading_log.h"
#include "anatomesh/contour/clean/resolved_slices.h"
#include "anatomesh/contour/planes/empty_slices.h"

namespace anatomesh {

// Gives the set its structures by number, and leaves out those without a contour. Warns: W-CON-001 for each of
// these. Error: E-CON-001 no structure has a contour.
Status keep_structures(const RawContours& raw, ContourSet& set, RunContext& context);

// Welds vertices that differ by rounding (weld.h). Returns the largest movement in mm. Warns: W-CON-021.
double weld_structures(ContourSet& set, double weld_mm, RunContext& context);

// Leaves out points that lie nearer than `crowded_mm` to the next (crowded_points.h), and logs them at the raw
// contours that had them. Warns: W-CON-032. Errors: those of leave_out_crowded().
Status thin_crowded_points(const RawContours& raw, double crowded_mm, ResolvedSlices& resolved,
                           ReadingLog& log, RunContext& context);

// Adds the planes of the file without contours (empty_slices.h), except those named by `without`. Warns:
// W-CON-031 for planes that find no place.
void add_empty_slices(std::vector<EmptyPlane> planes, const std::vector<std::string>& without,
                      double group_tolerance_mm, ContourSet& set, RunContext& context);

// Takes the set for that of a label map, exclusive and not drawn, where the file says so, its slices are complete and it
// is true (structure_overlap.h). Warns: W-CON-034 where the file says it and that is not so.
void settle_exclusive(const RawContours& raw, ContourSet& set, RunContext& context);

}  // namespace anatomesh
