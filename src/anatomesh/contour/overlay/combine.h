// combine_rings: the region that rings of one structure on one slice draw together, when they touch, cross or
// overlap themselves or each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// Areas of rings that differ by no more than this share of themselves differ by rounding. [1; > 0; D]
inline constexpr double area_rounding_share = 1e-9;

enum class CombineRule : std::uint8_t {
    nest_and_unite,  // inside another: hole, island ...; partial overlap: united
    exclusive_or,
    unite
};

// What became of one ring.
struct RingFate {
    double area_mm2 = 0;             // of its own even-odd interior
    double ambiguous_area_mm2 = 0;   // where it winds other than once in its main direction, or not at all
    bool touches_itself = false;     // visits a vertex twice
    bool retraces_itself = false;    // runs along an edge once each way: a keyhole's corridor
    std::uint32_t level = 0;         // even: adds; odd: a hole
    std::int32_t parent = -1;        // the smallest ring it lies in
    std::uint32_t group = 0;         // rings united with each other have the same: the smallest of them
    double protruding_area_mm2 = 0;  // of a hole or island beyond its parent; cut off
    bool shares_edge = false;        // with another ring
    std::uint32_t points_kept = 0;   // of its vertices, on the result's rings
};

// Two rings whose interiors overlap in part, neither being inside the other.
struct RingOverlap {
    std::uint32_t first = 0, second = 0;
    double area_mm2 = 0;
};

struct Combined {
    std::vector<Ring>
        rings;  // simple; two may share vertices, no edges. Their source: the smallest of their edges'
    std::vector<RingFate> fates;
    std::vector<RingOverlap> overlaps;
    std::map<std::pair<std::uint32_t, std::uint32_t>, double>
        common_mm2;                            // area common to two rings, smaller first
    std::vector<double> overlap_of_group_mm2;  // at the index of the group: area drawn more than once
    double sliver_area_mm2 = 0;  // of rings narrower than 1e-3 mm that only rounding made; left out

    double common_area(std::uint32_t first, std::uint32_t second) const {
        const auto entry = common_mm2.find({first, second});
        return entry == common_mm2.end() ? 0.0 : entry->second;
    }
};

// A ring counts as inside another when at most `share` of its area is outside. A ring of nearly the same area, within
// `share`, that crosses it is united with it instead. Returns nothing when the rings cross more than `most_edges`
// times. Every vertex of the result is a vertex of a ring, bit for bit, or a crossing. Complexity: that of arrange(),
// and O(rings^2) for their relations.
std::optional<Combined> combine_rings(std::span<const Ring> rings, const Plane& plane, CombineRule rule,
                                      double share, std::size_t most_edges);

}  // namespace anatomesh
