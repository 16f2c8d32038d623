// contradicted_segments: contour segments that no surface can have, since another slice draws otherwise
// there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// From point `index` of a contour to its next one.
struct SegmentOfContour {
    std::uint32_t contour = 0, index = 0;
    bool operator==(const SegmentOfContour&) const = default;
};

// Slices agree in a point where one's contour passes the other's plane when a contour of the other is this
// near: as far as vertices of a slice may be moved for another structure's sake (merge_coincident.h) and more than
// planes and points of files are off. [mm; > 0; C clause 1]
inline constexpr double contradiction_mm = 0.1;

// Of these segments those with a point in which their contour passes the plane of another slice, from one
// side to the other, and that slice says something else: it draws the structure, its contours reach as far
// (the box of all of them in its plane, as the field has it), and none of the structure's comes within
// contradiction_mm. Either the segment or that slice's cross-section can be the model's there, not both. Where a contour
// only touches a plane, runs along it or passes it at less than 1.2 degrees nothing is said. In the order
// given. Complexity: O(segments x slices), and the contours of those slices that are passed; O(slices) if all
// are parallel.
std::vector<SegmentOfContour> contradicted_segments(const ContourSet& contours,
                                                    std::span<const SegmentOfContour> segments);

}  // namespace anatomesh
