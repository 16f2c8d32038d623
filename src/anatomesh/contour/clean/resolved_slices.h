// resolve_slices: the contours of every slice, each structure on it resolved by itself.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/clean/candidate_slices.h"
#include "anatomesh/contour/clean/clean.h"

namespace anatomesh {

// Slices, contours and points of a contour set; the other fields are not set yet. A contour's structure is the
// index of the raw structure.
struct ResolvedSlices {
    ContourSet set;
    std::vector<std::uint32_t> source_of;  // per contour of the set: the raw contour that it came from
};

// Brings the points of each candidate onto the plane of its slice, drops candidates without area, and resolves
// the rings of each structure (resolve_rings()). Slices on which nothing is left are not in the result.
// Every contour begins at its lexicographically smallest vertex; those of a structure are in the order of these.
// Warns: W-CON-008..010, W-CON-012, W-CON-033 and what resolve_rings() notes. Errors: E-CON-005, E-CON-012,
// those of resolve_rings(), and cancelled.
Result<ResolvedSlices> resolve_slices(const RawContours& raw, std::vector<Candidate> candidates,
                                      const std::vector<CandidateSlice>& slices, const CleanOptions& options,
                                      ReadingLog& log, RunContext& context);

}  // namespace anatomesh
