// clean_contours: from contours as a file gave them to a kept contour set.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/model/raw_contours.h"

namespace anatomesh {

enum class HoleRule : std::uint8_t {
    even_odd,  // a contour inside another one is a hole (an island inside a hole, and so on)
    united     // every contour adds to the structure: holes are filled
};

struct CleanOptions {
    // Points this far off their plane are accepted as they are. [0, 1]
    double plane_tolerance_mm = 0.05;
    // Points up to this far off are projected, with a warning; beyond: refused. [plane_tolerance_mm, 10]
    double plane_repair_mm = 1.0;
    // Contours whose planes differ by less at their own extent may share a slice: see plane_grouping.h. [0,
    // 1]
    double group_tolerance_mm = 0.01;
    // An open contour with at most this gap is closed with a warning; one open at a heart's valve whatever
    // the gap is, up to half of what is drawn. [0, 100]
    double closing_gap_mm = 2.0;
    // A repair that makes a larger share of a contour's area ambiguous is refused. [0, 1]; 1: never refused
    double max_repair_area_share = 0.05;
    // A keyhole's corridor no wider than this is closed, so that outer contour and holes part. [0, 1]
    double corridor_mm = 0.05;
    // The same of a corridor with straight sides, ten times as long as it is wide, that leads to a hole: from
    // slice to slice it would be a slit, or a new tunnel where it turns. [0, 10]
    double keyhole_mm = 0.5;
    // Loops that a contour makes by crossing itself, slips of the pen, are no holes or islands of their own:
    // below this, and where close_loops.h says so. mm^2. [0, 100]; 0: as drawn. What crosses itself
    // and has no more than a ten-thousandth of it as its box is no contour.
    double loop_mm2 = 1;
    // A contour that keeps this near to another of its structure in its slice, and nearer than half of their
    // mean edge length, repeats it: the smaller is dropped. [0, 1]
    double repeat_mm = 0.05;
    // A hole that follows its outline as near as that is warned about, if that is also less than a tenth of
    // its radius or half of their mean edge length. [0, 10]
    double doubtful_wall_mm = 0.5;
    // Rings that share a vertex are moved apart there by at most this: a nearer wall or gap, on slice after
    // slice, would have holes. (0, 1]
    double separation_mm = 0.2;
    // Points nearer than this, and than 1e-4 of the span of all contours, to the next one of their contour,
    // that lie within a tenth of it of the line that is kept, are left out: cells as fine as they lie would
    // be finer than anything that is drawn. [0, 1]; 0: all stay.
    double crowded_mm = 0.01;
    // Vertices of different structures nearer than this become one: a wall that two structures share. [0,
    // 0.01]; 0: not.
    double weld_mm = 1e-4;
    HoleRule holes = HoleRule::even_odd;
    // Contours that contradict each other on a plane given twice: unite them instead of refusing.
    bool unite_repeated_planes = false;
    // Names of slices that are left out as if they were not drawn; named_slices() of chosen_slices.h. Of
    // several planes of a file that are one slice that alone which is called so.
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

// Guarantees: the invariants of a kept contour set, and no vertex is shared by two contours of one structure
// in one slice; a contour that needed no repair keeps every vertex at its exact coordinates; equal contours
// out for any order of the input's contours and structures, start index and direction. Structures come by
// number, without those that have no contour; declared planes say where contours lie (the planes' frames are
// made anew), and one without contours is an empty slice of a stack or a sweep (empty_slices.h). Same-plane
// rule, in this order: exact duplicates and near ones dropped; even-odd by containment; partial overlaps of
// one structure united; exclusive or only where the file says CLOSEDPLANAR_XOR. A contour that crosses itself
// is read by the even-odd rule. Where two rings have to share a vertex the larger keeps it, and the
// smaller one's corner is cut off or moved in (separate.h), separation_mm deep at most: a shared vertex would
// make every surface non-manifold. Every repair is counted and warned about, with its displacement and area;
// above its bound it is an error. Contours that span less than 1 mm in all are most likely in another unit:
// there the tolerances (plane, group, corridor, separation, weld) shrink with the span, so that nothing is
// lost. Errors: E-CON-001..012, warnings: W-CON-001..033. Complexity: O(n log n) per slice in its points,
// plus the crossings found.
Result<CleanResult> clean_contours(const RawContours& raw, const CleanOptions& options, RunContext& context);

}  // namespace anatomesh
