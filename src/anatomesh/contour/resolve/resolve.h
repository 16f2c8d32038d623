// resolve_rings: from the rings of one structure on one slice to rings that bound its drawn region and keep
// apart.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/resolve/ring_readings.h"

namespace anatomesh {

enum class HoleRule : std::uint8_t {
    even_odd,  // a contour inside another one is a hole (an island inside a hole, and so on)
    united     // every contour adds to the structure: holes are filled
};

struct ResolveOptions {
    HoleRule holes = HoleRule::even_odd;
    // Contours that contradict each other on a plane given twice are united instead of refused.
    bool unite_repeated_planes = false;
    // A repair that makes a larger share of a contour's area ambiguous is refused. [0, 1]; 1: never refused
    double max_repair_area_share = 0.05;
    // A corridor without width, but for rounding and up to this, is closed: one contour was drawn through its holes.
    // keyhole_mm is for corridors that were drawn with a width. [0, 1]
    double corridor_mm = 0.05;
    // A corridor of up to this width is closed as well, if it is straight, ten times as long as it is wide, and
    // leads to a hole. Left open it would be a slit from slice to slice, or a tunnel where it turns. [0, 10]
    double keyhole_mm = 0.5;
    // A contour that crosses itself in a loop below this area made a slip of the pen, and no hole or island;
    // close_loops.h has the conditions. What crosses itself in a box of at most a ten-thousandth of this is no
    // contour. mm^2. [0, 100]; 0: as drawn
    double loop_mm2 = 1;
    // A contour that keeps this near to another of its structure in its slice, and nearer than half of their
    // mean edge length, repeats it: the smaller is dropped. [0, 1]
    double repeat_mm = 0.05;
    // A hole that follows its outline as near as this is warned about. The distance is also less than a tenth of its
    // radius or half of their mean edge length. [0, 10]
    double doubtful_wall_mm = 0.5;
    // Rings that share a vertex are moved apart there by at most this: a nearer wall or gap, on slice after
    // slice, would have holes. (0, 1]
    double separation_mm = 0.2;

    bool operator==(const ResolveOptions&) const = default;
};

struct Resolved {
    std::vector<Ring> rings;  // simple, without a common point; outer ones counter-clockwise, holes clockwise
    std::vector<std::uint32_t> depth;   // per ring: even outer, odd hole
    std::vector<RingReading> readings;  // one per source
    std::vector<RingNote> notes;
};

// With `exclusive_or` the rings are combined by exclusive or (DICOM CLOSEDPLANAR_XOR) instead of nesting and union.
// `place_of` says where a source is, for messages. Requires: rings of three vertices or more, without repeated vertices
// and spikes, none equal to another, in an order that does not depend on the input's. Notes: W-CON-011, W-CON-013..020,
// W-CON-022, W-CON-026 and W-CON-030. Errors: E-CON-006..009. Complexity: O(n log n), plus the crossings found.
Result<Resolved> resolve_rings(std::vector<Ring> rings, const Plane& plane, bool exclusive_or,
                               const ResolveOptions& options, const PlaceOfSource& place_of);

}  // namespace anatomesh
