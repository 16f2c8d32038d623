// LoopStretches: parts of the contours of one slice, between two places on a contour.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/walls/conflated_contours.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A part of a loop: segments from this number on, the first from a share of it on and the last to one, and the vertices
// between them.
struct Stretch {
    std::uint32_t loop = 0;
    std::size_t start = 0, segments = 0;
    double from = 0, to = 1;  // of the first and of the last segment
    std::size_t vertices() const { return segments - 1; }
};

// The loops of a slice with the places of their vertices in its plane, and what stretches of them are. Both vectors are
// referred to and must outlive this. Complexity: O(segments of the stretch) a call, unless said.
class LoopStretches {
  public:
    LoopStretches(const std::vector<ConflatedContour>& loops, const std::vector<Vec2>& at)
        : loops_(loops), at_(at) {}

    // Between two places on a loop, the n-th vertex at n; over its start where the second is before the first. O(1).
    Stretch between(std::uint32_t loop, double from, double to) const;

    // The number of the stretch's k-th segment in its loop; the k-th vertex between segments; and the segment. O(1).
    std::uint32_t number(const Stretch& part, std::size_t k) const;
    std::uint32_t vertex(const Stretch& part, std::size_t k) const;
    Segment2 segment(const Stretch& part, std::size_t k) const;
    Vec2 at(std::uint32_t vertex) const { return at_[vertex]; }

    // The mean length of the segments between its vertices; of those at its ends where there are no others.
    double mean_segment(const Stretch& part) const;

    // The place on a stretch that is nearest to a point.
    struct PlaceOn {
        std::size_t segment = 0;
        double share = 0, apart = std::numeric_limits<double>::infinity();
    };
    PlaceOn nearest_place(const Stretch& part, Vec2 p) const;

    // The polygon between two stretches that run against each other.
    std::vector<Vec2> ring_between(const Stretch& first, const Stretch& second) const;

  private:
    const std::vector<ConflatedContour>& loops_;
    const std::vector<Vec2>& at_;
};

}  // namespace anatomesh
