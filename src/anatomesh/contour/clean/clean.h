// clean_contours: from contours as a file gave them to a kept contour set.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/contour/planes/plane_grouping.h"
#include "anatomesh/contour/resolve/resolve.h"

namespace anatomesh {

struct CleanOptions {
    PlaneGroupingOptions planes;  // on which plane contours lie, and which of them share a slice
    ResolveOptions rings;         // what the contours of one structure on one slice bound
    // An open contour with at most this gap is closed with a warning. One open at a heart's valve is closed
    // whatever the gap is, up to half of what is drawn. [0, 100]
    double closing_gap_mm = 2.0;
    // A point nearer than this to the next one of its contour is left out, if it lies within a tenth of this of
    // the line that is kept. Cells as fine as such points would be finer than anything that is drawn. At most
    // 1e-4 of the span of all contours counts. [0, 1]; 0: all stay.
    double crowded_mm = 0.01;
    // Vertices of different structures nearer than this become one: a wall that two structures share. [0,
    // 0.01]; 0: not.
    double weld_mm = 1e-4;
    // Slices of these names are left out as if they were not drawn (named_slices() of chosen_slices.h). Where
    // several planes of a file are one slice, only the plane so called is left out.
    std::vector<std::string> without;

    bool operator==(const CleanOptions&) const = default;
};

// How one contour of the input was read. One entry per raw contour, in input order: the log that travels into
// the report.
struct ContourLog {
    std::uint32_t raw_contour = 0;
    std::string rule;  // "outer", "hole of 12", "exclusive or", "dropped: one point", "repeat of 4" ...
    std::uint32_t points_in = 0, points_kept = 0;
    double max_displacement_mm = 0;  // largest move of a kept point
    double area_change_mm2 = 0;      // of the drawn region, absolute
};

struct CleanStats {
    std::uint64_t points_in = 0, points_kept = 0;
    std::uint32_t contours_in = 0, contours_kept = 0, repaired = 0, dropped = 0;
    double max_displacement_mm = 0;
};

struct CleanResult {
    ContourSet kept;
    std::vector<ContourLog> log;
    CleanStats stats;
};

// Guarantees: the invariants of a kept contour set, and no vertex is shared by two contours of one structure on one
// slice. A contour that needed no repair keeps every vertex at its exact coordinates. The result is the same for any
// order of contours and structures in the input, and for any start index and direction of a contour. Structures come by
// number, without those that have no contour. Declared planes say where contours lie; the planes' frames are made anew.
// A declared plane without contours is an empty slice of a stack or a sweep (empty_slices.h).
// Contours on one plane are read by these rules, in this order. Exact duplicates and near ones are dropped. A contour
// inside another one is a hole, by the even-odd rule. Partial overlaps of one structure are united. Contours are combined
// by exclusive or only where the file says CLOSEDPLANAR_XOR. A contour that crosses itself is read by the even-odd rule.
// Where two rings have to share a vertex the larger keeps it, because a shared vertex would make every surface
// non-manifold. The smaller one's corner is cut off or moved in (separate.h), separation_mm deep at most.
// Every repair is counted and warned about, with its displacement and area; above its bound it is an error. Contours
// that span less than 1 mm in all are most likely in another unit. There the tolerances (plane, group, corridor,
// separation, weld) shrink with the span, so that nothing is lost.
// Errors: E-CON-001..013, warnings: W-CON-001..035; those of
// complete_slices.h. Complexity: O(n log n) per slice in its points, plus the crossings
// found.
Result<CleanResult> clean_contours(const RawContours& raw, const CleanOptions& options, RunContext& context);

}  // namespace anatomesh
