// NeighborRings: what the other structures have in a slice while the contours of one are re-routed.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/improve/reroute/ring_ways.h"

namespace anatomesh {

class NeighborRings {
  public:
    // Requires: both outlive this.
    NeighborRings(std::span<const Vec3> points, const Plane& plane) : points_(points), plane_(plane) {}

    // The ring of another structure, as it is now. O(n log n)
    void add(const RoutedRing& ring, std::uint32_t structure);

    bool has(std::uint32_t v) const { return vertices_.contains(v); }
    // The vertices between a and b of the way that another structure's segment between them goes; nothing, if
    // there is none.
    std::optional<std::vector<std::uint32_t>> way_between(std::uint32_t a, std::uint32_t b) const;
    // Whether the way runs inside another structure; not of one that shares a segment in its place, which
    // goes the same way if it can. O(points)
    bool hold(const RoutedRing& ring, const RingWay& way) const;

  private:
    struct Twin {  // a way in the place of one segment
        std::uint32_t from = 0;
        std::vector<std::uint32_t> between;
    };
    static std::array<std::uint32_t, 2> ends(std::uint32_t a, std::uint32_t b) {
        return {std::min(a, b), std::max(a, b)};
    }
    Vec2 at(std::uint32_t v) const { return plane_.to_plane(points_[v]); }

    std::span<const Vec3> points_;
    const Plane& plane_;
    std::unordered_set<std::uint32_t> vertices_;
    std::vector<PlaneRing> rings_;
    // By ends, the smaller first: the structures that have the segment, and the ways.
    std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> sharing_;
    std::map<std::array<std::uint32_t, 2>, Twin> twins_;
};

}  // namespace anatomesh
