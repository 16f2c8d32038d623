// VertexSide: on which side of every structure's surface a vertex of the mesh lies.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/mesh/model/region_registry.h"

namespace anatomesh {

// A vertex lies in the structures of `in`; those that `may` has besides have their surface at it, so that
// cells of either side may meet there.
struct VertexSide {
    Region in = 0, may = 0;
    double depth_mm = 0;  // how far the nearest surface is that does not pass through it, by the field

    bool off_interfaces() const { return in == may; }
};

// Whether a cell of a region with these structures, in rising order, may have a vertex of this side.
inline bool allows(const RegionTable& table, VertexSide side, std::span<const std::uint32_t> structures) {
    const std::vector<std::uint32_t>&in = table.members[side.in], &may = table.members[side.may];
    return std::includes(structures.begin(), structures.end(), in.begin(), in.end()) &&
           std::includes(may.begin(), may.end(), structures.begin(), structures.end());
}

inline bool allows(const RegionTable& table, VertexSide side, Region region) {
    return side.off_interfaces() ? side.in == region : allows(table, side, table.members[region]);
}

// A structure that has the one vertex inside and the other one outside, so that its surface runs between
// them; nothing where both may belong to one region.
inline std::optional<std::uint32_t> parted_by(const RegionTable& table, VertexSide a, VertexSide b) {
    // Most vertices are of few sides: without a look at the table.
    const auto lies_in = [](VertexSide one, VertexSide other) {
        return one.in == 0 || one.in == other.in || one.in == other.may;
    };
    if (lies_in(a, b) && lies_in(b, a)) return std::nullopt;
    for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        const std::vector<std::uint32_t>&in = table.members[one.in], &may = table.members[other.may];
        for (const std::uint32_t s : in) {
            if (!std::binary_search(may.begin(), may.end(), s)) return s;
        }
    }
    return std::nullopt;
}

}  // namespace anatomesh
