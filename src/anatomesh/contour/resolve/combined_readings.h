// read_combined: what combine_rings() made of each ring, as readings and warnings.
#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/ring.h"
#include "anatomesh/contour/overlay/combine.h"
#include "anatomesh/contour/resolve/ring_readings.h"

namespace anatomesh {

// `made_vertices` counts, by source, the vertices of a ring that nobody drew. `max_repair_area_share`: of a
// ring's area, that may be ambiguous where it crosses itself. Warns: W-CON-014..017 and W-CON-019. Error:
// E-CON-006 more is ambiguous. Complexity: O(rings + overlaps log overlaps).
Status read_combined(std::span<const Ring> rings, const Combined& combined, CombineRule rule,
                     double max_repair_area_share, std::map<std::uint32_t, std::uint32_t>& made_vertices,
                     RingReadings& readings);

}  // namespace anatomesh
