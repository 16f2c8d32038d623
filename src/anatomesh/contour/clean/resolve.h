// resolve_rings: from the rings of one structure in one slice to rings that bound its drawn region and keep
// apart.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// How one source ring was read.
struct RingReading {
    std::uint32_t source = 0;
    std::string rule;
    std::uint32_t points_kept = 0;  // vertices of the result that are vertices of the source
    double displacement_mm = 0, area_change_mm2 = 0;
    bool repaired = false;
    bool adds = false;          // an outer one or an island: what it bounds is inside
    std::int64_t repeats = -1;  // the source of its plane that it nearly repeats and is dropped for
};

// A warning about a source ring; its place is filled in by the caller.
struct RingNote {
    std::uint32_t source = 0;
    Warning warning;
};

struct Resolved {
    std::vector<Ring> rings;  // simple, without a common point; outer ones counter-clockwise, holes clockwise
    std::vector<std::uint32_t> depth;   // per ring: even outer, odd hole
    std::vector<RingReading> readings;  // one per source
    std::vector<RingNote> notes;
};

// Where a source is, for messages.
using PlaceOfSource = std::function<Place(std::uint32_t source)>;

// Requires: rings of three vertices or more, without repeated vertices and spikes, none equal to another, in
// an order that does not depend on the input's. `exclusive_or`: combine by exclusive or (DICOM
// CLOSEDPLANAR_XOR) instead of nesting and union. Errors: E-CON-006..009.
Result<Resolved> resolve_rings(std::vector<Ring> rings, const Plane& plane, bool exclusive_or,
                               const CleanOptions& options, const PlaceOfSource& place_of);

}  // namespace anatomesh
