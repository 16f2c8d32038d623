// Candidates: the raw contours that may bound something, closed and in an order that no file decides.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/clean/reading_log.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A raw contour without repeated points, turned to its canonical start and direction (canonicalize_cycle()).
struct Candidate {
    std::uint32_t raw = 0;  // index into RawContours::contours
    std::vector<Vec3> points;
};

// The structures' indices in the order of their numbers; equal numbers keep the order of the file.
std::vector<std::uint32_t> structures_by_number(const std::vector<Structure>& structures);

// Errors: E-CON-002 a coordinate is not finite, E-CON-003 it lies beyond 1e7 mm. O(points).
Status check_coordinates(const RawContours& raw);

// Leaves out markers, contours of fewer than three points and open contours that stay open; closes the others
// over a gap of at most `closing_gap_mm`, or at a heart's valve (close_at_valve.h). Drops repeated points.
// Returns the candidates by structure number, then by points in lexicographic order. Warns: W-CON-003..007 and
// W-CON-029. Error: E-CON-004 all points of a contour are equal. O(n log n).
Result<std::vector<Candidate>> gather_candidates(const RawContours& raw, double closing_gap_mm,
                                                 ReadingLog& log);

// Drops every candidate that equals another one of its structure, and keeps the first of the input. Warns:
// W-CON-011. Errors: those of check_repeat(). Requires: the order of gather_candidates(). O(points).
Status drop_repeats(const RawContours& raw, std::vector<Candidate>& candidates, ReadingLog& log);

// Error E-CON-012: one contour repeats another one, but the file calls only one of the two a hole. What is left
// would be nothing, or a region that the file says is a hole, and only the user can decide.
Status check_repeat(const RawContours& raw, std::uint32_t contour, std::uint32_t repeated);

}  // namespace anatomesh
