#include "anatomesh/reconcile/move/apply_movement.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/contour/overlay/slice_soundness.h"

namespace anatomesh {

namespace {

// A movement is shortened so often where contours would cross; then the place stays as it is.
// [shortenings; >= 1; B]
constexpr int most_shortenings = 16;
// A step is shortened up to this far along the contour, and further where that did not help.
// [mm; > 0; M 2026-11, set not recorded]
constexpr double shortening_reach_mm = 3;
// After so many shortenings in vain the reach grows by shortening_reach_mm. [shortenings; >= 1; B]
constexpr int shortenings_per_reach = 4;

// Holds the moves of all nodes, and the share of each that keeps its slice sound.
class BoundedMovement {
  public:
    BoundedMovement(const ContourSet& set, const ContourGraph& graph, const OriginalPositions& drawn,
                    const std::vector<Vec2>& moves, double most_mm)
        : set_(set),
          graph_(graph),
          drawn_(drawn),
          moves_(moves),
          most_mm_(most_mm),
          shares_(moves.size(), 1.0) {}

    // Lessens the shares of the slice's nodes until its contours are sound. Slices have no nodes in common.
    void shorten(const Slice& slice) {
        for (int n = 0; n < most_shortenings; ++n) {
            const std::vector<RingSegment> faults = slice_faults(rings_of(slice), set_.exclusive);
            if (faults.empty()) return;
            const double reach = shortening_reach_mm * (1 + n / shortenings_per_reach);
            for (const RingSegment fault : faults)
                shorten_around(set_.contours[slice.first_contour + fault.ring], fault.place, reach);
        }
        for (const Contour& contour : set_.contours_of(slice)) {
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
                shares_[graph_.node_of_point[k]] = 0;
        }
    }

    // Returns where a point comes to, which is never further from where it was drawn than the bound.
    Vec3 moved(const Plane& plane, std::uint32_t point) const {
        const std::uint32_t node = graph_.node_of_point[point];
        const Vec2 move = shares_[node] * moves_[node];
        if (move == Vec2{}) return set_.points[point];
        const Vec3 to = set_.points[point] + (move.x * plane.u + move.y * plane.v),
                   way = to - drawn_.at[point];
        const double distance = length(way);
        if (distance <= most_mm_) return to;
        // Rounding may lead beyond the bound again, so the way is shortened until it does not.
        for (double less = 0;; less = std::max(2 * less, std::numeric_limits<double>::epsilon())) {
            const Vec3 at = drawn_.at[point] + ((1 - less) * most_mm_ / distance) * way;
            if (length(at - drawn_.at[point]) <= most_mm_) return at;
        }
    }

  private:
    std::vector<PlaneRing> rings_of(const Slice& slice) const {
        std::vector<PlaneRing> rings;
        for (const Contour& contour : set_.contours_of(slice)) {
            PlaneRing ring{contour.structure, {}};
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
                ring.at.push_back(slice.plane.to_plane(moved(slice.plane, k)));
            rings.push_back(std::move(ring));
        }
        return rings;
    }

    // Halves the shares of the points within reach of a segment of a contour, and lessens those further out
    // by less.
    void shorten_around(const Contour& contour, std::uint32_t place, double reach) {
        for (const bool forward : {false, true}) {
            std::uint32_t k = contour.first_point + place;
            if (forward) k = point_after(contour, k);
            double walked = 0;
            for (std::uint32_t n = 0; n < contour.point_count && walked < reach; ++n) {
                shares_[graph_.node_of_point[k]] *= 0.5 + 0.5 * walked / reach;
                const std::uint32_t next = forward ? point_after(contour, k) : point_before(contour, k);
                walked += length(set_.points[next] - set_.points[k]);
                k = next;
            }
        }
    }

    const ContourSet& set_;
    const ContourGraph& graph_;
    const OriginalPositions& drawn_;
    const std::vector<Vec2>& moves_;
    const double most_mm_;
    std::vector<double> shares_;  // per node
};

}  // namespace

void apply_movement(ContourSet& set, const ContourGraph& graph, const OriginalPositions& drawn,
                    const std::vector<Vec2>& moves, double most_mm, int threads) {
    assert(most_mm > 0 && drawn.at.size() == set.points.size());
    BoundedMovement movement(set, graph, drawn, moves, most_mm);
    parallel_for(set.slices.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) movement.shorten(set.slices[s]);
    });
    for (const Contour& contour : set.contours) {
        const Plane& plane = set.slices[contour.slice].plane;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
            set.points[k] = movement.moved(plane, k);
    }
}

}  // namespace anatomesh
