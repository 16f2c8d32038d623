// ReconcileOptions, ReconcileStats: what reconcile_contours() is asked for, and what it did.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/walls/merge_coincident.h"
#include "anatomesh/contour/walls/slivers.h"
#include "anatomesh/reconcile/regularize/enforce_clearance.h"
#include "anatomesh/reconcile/regularize/flatten_folds.h"
#include "anatomesh/reconcile/regularize/regularize_along_axis.h"
#include "anatomesh/reconcile/regularize/regularize_fans.h"
#include "anatomesh/reconcile/resolve/resolve_conflicting_intervals.h"

namespace anatomesh {

struct ReconcileOptions {
    // Move contours so that crossing slices agree. false: keep every drawn vertex, only measure.
    bool reconcile = true;
    // First shift every slice rigidly in its plane (breathing, a probe that slips) so that they agree best.
    bool align = false;
    // Slices that are further apart than this where their planes cross are refused, by the median of a
    // pair, or where a contour would have to move further. So are larger shifts. mm, (0, 1000]
    double max_disagreement_mm = 10;
    // A movement fades over this length along a contour. working units (working_unit.h), [0.1, 1000]
    double smoothing = 10;
    // So far beyond its own contours a slice still says "outside". mm, [0, 1000]; 0: the spacing of the
    // planes
    double margin_mm = 0;
    // Contours of different structures that come to lie nearer to each other than this share their vertices
    // (merge_coincident.h). mm, [0, 0.1]; without a value MergeCoincidentOptions::width_mm in working units
    std::optional<double> same_line_mm = {};
    // A sliver between two such contours that is narrower than this is closed (slivers.h). mm, [0, 10]; without a
    // value CloseSliversOptions::width_mm in working units
    std::optional<double> close_slivers_mm = {};
};

// Two slices on their common line, all structures together: distances along the line.
struct PairDisagreement {
    std::uint32_t slice_a = 0, slice_b = 0;        // a < b
    std::uint32_t ends = 0;                        // endpoints that correspond to each other
    std::uint32_t unmatched = 0;                   // intervals and gaps that one of the two does not have
    double median_mm = 0, p95_mm = 0, max_mm = 0;  // of corresponding ends
    double difference_mm = 0;                      // length of the regions' symmetric difference
    double difference_after_mm = 0;                // the same for the contours that are kept
};

struct SliceMovement {
    // Movement of its drawn vertices, without the shift. Before fans are regularized, vertices are
    // measured before they come to a common point within 0.05 mm.
    double mean_mm = 0, max_mm = 0;
    Vec3 shift;  // by align, in the slice's plane
};

// A structure of a slice whose contour was taken over a line. On the line the slice lacked what most of
// the slices through it have, or had what they lack; or the same of one other slice, where that is the least
// movement.
struct TakenOver {
    std::uint32_t slice = 0, structure = 0;
    double farthest_mm = 0;  // of the contour from the line
    bool for_most = true;    // of the slices through the line, or for one other alone
};

// All slices on all common lines together.
struct TotalDisagreement {
    std::uint64_t ends = 0, unmatched = 0;
    double median_mm = 0, p95_mm = 0, max_mm = 0;  // over all ends, as drawn (after align)
    double difference_mm = 0, difference_after_mm = 0;
};

struct ReconcileStats : TotalDisagreement {
    std::vector<PairDisagreement> pairs;   // of crossing slices that draw something there, in order
    std::vector<SliceMovement> movements;  // per slice of the set
    double mean_movement_mm = 0, max_movement_mm = 0;
    std::uint64_t shared_points = 0;         // points on common lines that contours of both slices now have
    FoldStats folds;                         // that the movement made, cut off
    FanStats fans;                           // where contours rose and fell from plane to plane
    std::vector<TakenOver> taken_over;       // by slice and structure
    std::vector<ResolvedInterval> resolved;  // pieces of common lines, in order
    AlongAxisStats along_axis;               // the same beside lines, along them
    ClearanceStats clearance;                // contours that all but touched
    ConflationStats slivers;                 // between structures, closed where the movement left them
    ConflationStats shared_lines;            // of structures that came to lie on each other
    std::uint32_t rounds = 0;
};

}  // namespace anatomesh
