// The boundary of a drawn region cut into pieces, and the search for the piece of another boundary that a
// piece corresponds to.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh {

inline constexpr std::uint32_t no_piece = std::numeric_limits<std::uint32_t>::max();

// A stretch of a boundary.
struct BoundaryPiece {
    Vec2 a, b, facing;  // facing: unit vector out of the region, 0 where it cannot be told
    double length = 0;
    Vec2 middle() const { return 0.5 * (a + b); }
};

struct Boundary {
    std::vector<BoundaryPiece> pieces;
    std::vector<std::uint32_t> first;  // piece of each edge of the region; the number of pieces at the end
    std::vector<std::uint32_t> next, previous;  // along the boundary; no_piece where it cannot be told
    std::vector<std::uint32_t> outline;         // of each piece; numbered by their first pieces
    std::uint32_t outlines = 0;
};

// The edge that starts where each edge ends, no_piece where none does; where several do, the first that is
// not taken yet. Complexity: O(n log n).
std::vector<std::uint32_t> following_edges(std::span<const Edge2> edges);

// Edges longer than half a gap in pieces of that length; a piece faces across the chord of the boundary half
// a gap to both sides. `gap`: the distance of the two slices, mm. Complexity: O(n log n).
Boundary boundary_of(const DistanceMap& map, double gap);

// The pieces of a boundary in square bins, to search round a point. Complexity: construction and memory
// linear; a search O(1) for pieces spread evenly.
class PieceIndex {
  public:
    PieceIndex(const Boundary& boundary, double gap);

    struct Match {
        std::uint32_t piece = no_piece;
        Vec2 point;
    };

    // The point of the boundary for one at `from` that faces `facing` and is expected at `target`: the
    // nearest to the target, a difference of facing counting as distance, within 3.5 gaps of both.
    Match nearest(Vec2 from, Vec2 facing, Vec2 target) const;
    // The same, of one outline alone and within `reach` (mm).
    Match nearest(Vec2 from, Vec2 facing, Vec2 target, double reach, std::uint32_t outline) const;

  private:
    template <class Accepts>
    Match search(Vec2 from, Vec2 facing, Vec2 target, double reach, const Accepts& accepts) const;

    std::int64_t column(double x, double low) const {
        return static_cast<std::int64_t>(std::floor((x - low) / bin_));
    }
    std::size_t bin_of(Vec2 q) const;
    template <class Body>
    void each_in_row(std::int64_t j, std::int64_t first, std::int64_t last, const Body& body) const;

    // A piece made ready for the search; those of a bin lie together.
    struct Listed {
        Vec2 a, edge, facing;
        double inverse;  // of the squared length
        std::uint32_t number, outline;
    };
    double gap_, bin_ = 1;
    Box2 box_;
    std::int64_t nx_ = 1, ny_ = 1;
    std::vector<std::uint32_t> begin_;
    std::vector<Listed> listed_;
};

// A boundary ready to be matched with.
struct BoundarySide {
    Boundary boundary;
    PieceIndex index;
    BoundarySide(const DistanceMap& map, double gap)
        : boundary(boundary_of(map, gap)), index(boundary, gap) {}
};

}  // namespace anatomesh
