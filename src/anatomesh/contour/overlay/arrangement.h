// Arrangement: the rings of a slice, split at all their crossings, and how each ring winds around every face.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/ring.h"

namespace anatomesh {

// A loop that is narrower in the mean, area over half of its perimeter, is what rounding left.
// [mm; > 0; D rounding of snapped points]
inline constexpr double sliver_width_mm = 1e-3;
// More edges of one slice are refused. [edges; > 0; B]
inline constexpr std::size_t most_arrangement_edges = 20'000'000;

// How often a ring winds around a face, counter-clockwise positive; never 0 in a list.
struct RingTurns {
    std::uint32_t ring = 0;
    std::int32_t turns = 0;
    friend bool operator==(const RingTurns&, const RingTurns&) = default;
};
using Winding = std::vector<RingTurns>;  // ascending by ring

// A plane graph: edges meet only at vertices, by exact predicates on the vertices' coordinates.
struct Arrangement {
    // a before b in lexicographic order; left and right of a -> b are indices into windings.
    struct Edge {
        std::uint32_t a = 0, b = 0;
        std::uint32_t left = 0, right = 0;
    };
    std::vector<Vec2> at;
    std::vector<Vec3> points;  // parallel to at; those of the rings' vertices are theirs, bit for bit
    std::vector<Edge> edges;   // those at which the winding of some ring changes
    std::vector<Winding> windings;
    // The cycle of vertices that each ring became; an edge of it that the ring runs once each way is not in
    // edges.
    std::vector<std::vector<std::uint32_t>> cycles;
};

// New vertices are made only where two edges cross in their interior; their coordinates are rounded to doubles. A
// crossing within 1e-6 mm of a vertex takes that vertex. Edges that cross at an angle below 1e-9 run along each other,
// and each takes the ends of the other that lie beside it. Edges are then tested again against all others until nothing
// crosses, so that rounding leaves no crossing behind. A vertex on an edge splits it without moving it. Returns nothing
// when there are more than `most_edges` edges or rounding does not come to rest. Complexity: O((n + k) log n) with k
// crossings, times the passes (2 or 3 as a rule).
std::optional<Arrangement> arrange(std::span<const Ring> rings, const Plane& plane, std::size_t most_edges);

}  // namespace anatomesh
