// Rings of candidates: one contour at a time is brought onto the plane of its slice and made a ring.
#pragma once

#include <optional>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/clean/candidate_slices.h"
#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// Moves points that lie further than the tolerance off the plane onto it; the others stay, bit for bit. Returns
// how far those that stay spread along the normal, in mm. Warns: W-CON-009. Error: E-CON-005 a point lies
// further off than `plane_repair_mm`. O(points).
Result<double> move_onto_plane(const RawContours& raw, const CandidateSlice& slice,
                               const PlaneGroupingOptions& options, Candidate& candidate, ReadingLog& log);

// The candidate as a ring without spikes; nothing where it has no area, or where it crosses itself within a box
// of at most 1e-4 of `loop_mm2`: this is noise of what drew it. Warns: W-CON-008, W-CON-012. O(n log n).
std::optional<Ring> ring_of(const RawContours& raw, const Plane& plane, double loop_mm2, Candidate candidate,
                            ReadingLog& log);

}  // namespace anatomesh
