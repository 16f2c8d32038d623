// combine_area: an area that was drawn, united with the rings of a structure, taken from them, or put in their place.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

enum class AreaRule : std::uint8_t {
    unite,            // what is drawn is added
    subtract,         // what is drawn is taken away
    subtract_or_add,  // taken away where it overlaps the structure; where it overlaps nothing, a part of its own
    replace           // the parts of the structure that it overlaps go, and what is drawn is added
};

// What became of the structure. A part is an outer ring with its holes; an island in a hole is a part of its own.
enum class AreaEffect : std::uint8_t { nothing, new_part, extended, cut, replaced, reshaped };

struct CombinedArea {
    StructureRings rings;
    std::vector<std::int32_t> came_from;      // per ring: the first ring before that it has a piece of, or -1
    AreaEffect effect = AreaEffect::nothing;  // nothing: the rings are those before, bit for bit
    std::uint32_t mended_crossings = 0;       // of the area's rings with themselves and each other
    bool is_area_empty = false;               // the area has no interior
    double sliver_area_mm2 = 0;               // of rings that only rounding made; left out
};

// The area is the even-odd interior of its rings, which may cross themselves and each other. Holes and islands at any
// depth stay. Every vertex of the result is a vertex of a ring or of the area, bit for bit, or a crossing. A ring
// that the area does not reach keeps its vertices, its start and its direction, and so does each stretch of a ring away
// from crossings; rings that are joined run as the first of them. Rings stay in their order, a ring that is split is
// followed by its pieces, and rings of the area alone come last. A second call with the same area changes
// nothing, but with subtract_or_add, which then overlaps nothing and adds.
// Requires: sound rings; rings of the area of any number of points, without two equal ones in turn. Error: limit
// E-LIV-007 the edges cross too often. Complexity: that of arrange() for the area and the rings whose boxes it meets;
// for all rings with AreaRule::replace.
Result<CombinedArea> combine_area(const StructureRings& before, std::span<const Ring> area, AreaRule rule);

}  // namespace anatomesh
