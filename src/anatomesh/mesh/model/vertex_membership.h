// VertexMembership: on which side of every structure's surface a vertex of the mesh lies.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/mesh/model/region_registry.h"

namespace anatomesh {

// A vertex lies in the interior of structures, and in the closure of these and of those that have their
// surface at it, so that cells of either side may meet there.
struct VertexMembership {
    Region interior_of = 0, closure_of = 0;
    double depth_mm = 0;  // how far the nearest surface is that does not pass through it, by the field

    bool off_interfaces() const { return interior_of == closure_of; }
};

// Whether a cell of a region with these structures, in rising order, may have a vertex of this side.
inline bool allows(const RegionTable& table, VertexMembership side,
                   std::span<const std::uint32_t> structures) {
    const std::vector<std::uint32_t>&interior_of = table.members[side.interior_of],
          &closure_of = table.members[side.closure_of];
    return std::includes(structures.begin(), structures.end(), interior_of.begin(), interior_of.end()) &&
           std::includes(closure_of.begin(), closure_of.end(), structures.begin(), structures.end());
}

inline bool allows(const RegionTable& table, VertexMembership side, Region region) {
    return side.off_interfaces() ? side.interior_of == region : allows(table, side, table.members[region]);
}

// A structure that has the one vertex inside and the other one outside, so that its surface runs between
// them; nothing where both may belong to one region.
inline std::optional<std::uint32_t> parted_by(const RegionTable& table, VertexMembership a,
                                              VertexMembership b) {
    // Most vertices are of few sides: without a look at the table.
    const auto lies_in = [](VertexMembership one, VertexMembership other) {
        return one.interior_of == 0 || one.interior_of == other.interior_of ||
               one.interior_of == other.closure_of;
    };
    if (lies_in(a, b) && lies_in(b, a)) return std::nullopt;
    for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        const std::vector<std::uint32_t>&interior_of = table.members[one.interior_of],
              &closure_of = table.members[other.closure_of];
        for (const std::uint32_t s : interior_of) {
            if (!std::binary_search(closure_of.begin(), closure_of.end(), s)) return s;
        }
    }
    return std::nullopt;
}

}  // namespace anatomesh
