#include "anatomesh/live/draw/space_vertices.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

namespace {

class VertexSpacing {
  public:
    VertexSpacing(const StructureRings& before, double least_mm, StructureRings& after)
        : least_(least_mm), after_(after) {
        for (const Ring& ring : before.rings) {
            old_.insert(old_.end(), ring.points.begin(), ring.points.end());
            for (std::size_t i = 0; i < ring.size(); ++i) {
                longest_ = std::max(longest_, length(ring.at[(i + 1) % ring.size()] - ring.at[i]));
            }
        }
        std::sort(old_.begin(), old_.end(), LexicographicLess{});
    }

    void run() {
        for (std::size_t r = 0; r < after_.rings.size(); ++r) {
            drop_crowded(r);
            split_long(after_.rings[r]);
        }
    }

  private:
    bool is_new(Vec3 point) const {
        return !std::binary_search(old_.begin(), old_.end(), point, LexicographicLess{});
    }

    // Goes around the ring until every vertex stays.
    void drop_crowded(std::size_t r) {
        Ring& ring = after_.rings[r];
        for (bool changed = true; changed;) {
            changed = false;
            for (std::size_t i = 0; i < ring.size() && ring.size() > 3; ++i) {
                if (!is_crowded(r, i)) continue;
                ring.at.erase(ring.at.begin() + static_cast<std::ptrdiff_t>(i));
                ring.points.erase(ring.points.begin() + static_cast<std::ptrdiff_t>(i));
                changed = true;
            }
        }
    }

    // Whether a new vertex is too near to a neighbour and may go.
    bool is_crowded(std::size_t r, std::size_t i) const {
        const Ring& ring = after_.rings[r];
        const std::size_t n = ring.size();
        const Vec2 p = ring.at[(i + n - 1) % n], x = ring.at[i], q = ring.at[(i + 1) % n];
        if (std::min(length(x - p), length(q - x)) >= least_) return false;
        return is_new(ring.points[i]) && may_go(r, p, x, q);
    }

    // Whether the segment pq can take the place of p, x, q on ring r.
    bool may_go(std::size_t r, Vec2 p, Vec2 x, Vec2 q) const {
        Box2 box;
        for (const Vec2 corner : {p, x, q}) box.extend(corner);
        for (std::size_t s = 0; s < after_.rings.size(); ++s) {
            const std::vector<Vec2>& at = after_.rings[s].at;
            for (std::size_t i = 0; i < at.size(); ++i) {
                const Vec2 a = at[i], b = at[i + 1 < at.size() ? i + 1 : 0];
                if (std::max(a.x, b.x) < box.low.x || std::min(a.x, b.x) > box.high.x ||
                    std::max(a.y, b.y) < box.low.y || std::min(a.y, b.y) > box.high.y) {
                    continue;
                }
                const bool is_own = s == r && (a == x || b == x);
                if (!is_own && (is_in_the_way(s == r, a, b, p, q) || is_within(a, p, x, q))) return false;
            }
        }
        return true;
    }

    // Whether ab and pq have more in common than the end of a neighbour.
    static bool is_in_the_way(bool same_ring, Vec2 a, Vec2 b, Vec2 p, Vec2 q) {
        const SegmentContact contact = segment_contact(a, b, p, q);
        if (contact == SegmentContact::none) return false;
        return !(same_ring && contact == SegmentContact::touch && (b == p || a == q));
    }

    static bool is_within(Vec2 v, Vec2 p, Vec2 x, Vec2 q) {
        if (v == p || v == q) return false;
        const int a = orient2d(p, x, v), b = orient2d(x, q, v), c = orient2d(q, p, v);
        return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
    }

    void split_long(Ring& ring) {
        Ring longer;
        longer.source = ring.source;
        longer.plane = ring.plane;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vec2 a = ring.at[i], b = ring.at[(i + 1) % ring.size()];
            longer.push_back(a, ring.points[i]);
            const double pieces = std::ceil(length(b - a) / longest_);
            for (double k = 1; k < pieces; ++k) {
                const Vec3 point = after_.plane.to_space(a + (k / pieces) * (b - a));
                longer.push_back(after_.plane.to_plane(point), point);
            }
        }
        ring = std::move(longer);
    }

    const double least_;
    StructureRings& after_;
    std::vector<Vec3> old_;  // sorted
    double longest_ = 0;     // edge before
};

}  // namespace

void space_new_vertices(const StructureRings& before, double least_mm, StructureRings& after) {
    VertexSpacing(before, least_mm, after).run();
}

}  // namespace anatomesh
