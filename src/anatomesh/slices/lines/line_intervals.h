// compare_planes: where the drawn regions of two crossing slices begin and end on their common line.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/lines/match_intervals.h"

namespace anatomesh {

// Distances from a plane below this are rounding: the point lies on the plane. [mm; > 0; D]
inline constexpr double line_in_plane_mm = 1e-7;
// What was computed from such points lies on the plane if it is nearer than this. [mm; > 0; D]
inline constexpr double beside_plane_mm = 10 * line_in_plane_mm;

struct Line {
    Vec3 origin, direction;  // unit direction
    Vec3 at(double t) const { return origin + t * direction; }
    double along(Vec3 p) const { return dot(p - origin, direction); }
};

// The common line of two planes that cross; the origin is its point nearest to `near`.
Line common_line(const Plane& a, const Plane& b, Vec3 near);

// A place where a contour passes from one side of another plane to the other.
struct IntervalEndpoint {
    std::uint32_t contour = 0;
    std::uint32_t from = 0, to = 0;  // the segment's points, indices into the set's; equal: at that point
    Vec3 at;                         // the place: the same bits for a segment that two contours share
    double t = 0;                    // along the line, mm
};

// One structure on the common line of two slices, a < b.
struct LineComparison {
    std::uint32_t a = 0, b = 0, structure = 0;
    Line line;
    std::vector<IntervalEndpoint> endpoints_a, endpoints_b;  // ascending in t
    IntervalMatching matching;                               // first: a, second: b
    std::array<double, 2> seen_by_a{}, seen_by_b{};  // the part of the line that each says something of, in t
    double difference_mm = 0;  // symmetric difference of the two regions' parts on the line
};

// Compares every structure that either slice of a pair draws on their common line; what lies further than
// `margin` beyond the contours of the other slice is left out, since that says nothing there. A contour that
// touches the plane or runs along it is read in the way that agrees better with the other slice. In order of
// pairs and structures. Complexity: per pair, blocks of 16 points are looked at only when they are near the
// other plane.
std::vector<LineComparison> compare_planes(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                           const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
                                           double margin, RunContext& context);

// How far all slices are from agreeing: the sum of the comparisons' differences, mm. O(comparisons).
double total_difference_mm(std::span<const LineComparison> comparisons);

}  // namespace anatomesh
