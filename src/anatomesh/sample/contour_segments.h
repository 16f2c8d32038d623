// Contour segments as subsegments between vertices of the sample: what must become chains of edges of the
// mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// A straight subsegment of one structure. A segment that several structures share has a subsegment for each.
struct Subsegment {
    std::uint32_t a = 0, b = 0;  // indices of points, a != b
    std::uint32_t structure = 0;
    std::uint32_t ball = 0;  // of a ProtectedSegments; the same for all structures that share it
    friend auto operator<=>(const Subsegment&, const Subsegment&) = default;
};

// A distinct segment between two points, with the structures that have it in a contour.
struct ContourSegment {
    std::uint32_t a = 0, b = 0;  // a < b
    std::uint32_t slice = 0;     // the first one that it lies in
    std::vector<std::uint32_t> structures;
};

// `vertices` gives the point of every point of the contour set. Sorted by (a, b).
std::vector<ContourSegment> distinct_segments(const ContourSet& contours,
                                              const std::vector<std::uint32_t>& vertices);

// A point within a segment: where contours of different structures cross or touch.
struct SegmentCut {
    std::uint32_t segment = 0;
    double share = 0;  // of the way from a to b, in (0, 1)
    std::uint32_t point = 0;
    friend auto operator<=>(const SegmentCut&, const SegmentCut&) = default;
};

// Both segments of a crossing are cut at one new point, appended to `points`, but not within `clearance_mm`
// of an end: points so close would force tiny cells. Where a segment's end lies on another one (within 1e-6
// of its length), that one is cut there, however near to its own ends: the point is there in any case.
// Sorted; at most one cut of a segment at a point. Complexity: O(n log n + contacts).
std::vector<SegmentCut> cuts_at_contacts(const ContourSet& contours,
                                         const std::vector<ContourSegment>& segments, double clearance_mm,
                                         std::vector<Vec3>& points);

// A part of segments between cuts, a < b; where contours run along each other several have it, and their
// structures are its.
struct SegmentPart {
    ContourSegment segment;
    std::vector<std::uint32_t> of;  // the segments; rising
};

// What the cuts leave of the segments, each once, along the segments in their order. `cuts`: as
// cuts_at_contacts(). Complexity: O(n log n).
std::vector<SegmentPart> parts_between(const std::vector<ContourSegment>& segments,
                                       const std::vector<SegmentCut>& cuts);

// Vertices at which subsegments meet at acute angles, in rising order. Complexity: O(n log n)
// in the subsegments, and the pairs at a vertex.
std::vector<std::uint32_t> acute_vertices(std::span<const Vec3> points,
                                          const std::vector<Subsegment>& subsegments);

// Where a subsegment is split: at its middle; but one of those that meet at an acute angle (`acute`: as
// acute_vertices()) at a distance from where they meet that is a power of two, from a third to two thirds of
// its length.
Vec3 split_point(std::span<const Vec3> points, const Subsegment& subsegment,
                 std::span<const std::uint32_t> acute);

// Where a subsegment is split that lies on the way from a vertex where subsegments meet at acute angles: at a
// distance from this `apex` that is the roundest binary number in the middle half of the subsegment. Split
// so again and again, all that meet there get the same distances as far as they reach; then none of their
// parts lies in the ball of another, and splitting ends (Shewchuk, Delaunay refinement mesh generation, 1997,
// chapter 3: concentric shells). Requires: the way from one end to the other leads away from the apex.
Vec3 shell_point(std::span<const Vec3> points, const Subsegment& subsegment, Vec3 apex);

// The foot of p on a subsegment. Split there, the subsegment has p in the ball of neither half, and no
// subsegment that ends at p and goes on beside this one has the foot in its ball: where two contours cross at
// a small angle, vertices that stand opposite each other leave them both edges. None where p is nearer to it
// than 0.005 of the shorter half: cells between contours that cross at less than 0.3 degrees would be worth
// less than the subsegment.
std::optional<Vec3> foot_on(std::span<const Vec3> points, const Subsegment& subsegment, Vec3 p);

// No other vertex is this near to a foot. [its distances from p; 0 to 1; M 2026-11 16 structures of a head]
constexpr double foot_room = 0.5;

}  // namespace anatomesh
