// CandidateSlices: the candidates of a file grouped by slice, before their contours are repaired.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/clean/candidates.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/planes/empty_slices.h"
#include "anatomesh/contour/planes/plane_grouping.h"

namespace anatomesh {

struct CandidateSlice {
    Plane plane;
    double spread_mm = 0;                  // between the contours' own planes, the first and the last
    std::string name;                      // for messages
    std::vector<std::string> given_names;  // of its planes in the file, sorted and distinct
    std::vector<std::uint32_t> members;    // indices of candidates, rising
};

struct CandidateSlices {
    std::vector<CandidateSlice> slices;    // in the order of group_planes()
    std::vector<EmptyPlane> empty_planes;  // planes of the file on which no contour lies
};

// Whether `name` is one of `names`; case and blanks do not count.
bool is_one_of(const std::vector<std::string>& names, const std::string& name);

// Finds the slice of each candidate (group_planes()) and names the slices.
CandidateSlices group_candidates(const RawContours& raw, const std::vector<Candidate>& candidates,
                                 const PlaneGroupingOptions& options);

// Takes the contours of the slices called `without` out of their slices, before anything in them can be
// refused. Where several planes of the file are one slice, only contours of the planes so called leave.
// Returns what was drawn there. Errors: E-CON-010, E-CON-011 (chosen_slices.h).
Result<std::vector<LeftOutSlice>> leave_out_slices(const RawContours& raw,
                                                   const std::vector<Candidate>& candidates,
                                                   const std::vector<std::string>& without,
                                                   CandidateSlices& slices, ReadingLog& log);

}  // namespace anatomesh
