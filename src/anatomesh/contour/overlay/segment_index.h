// SegmentIndex: a tree of boxes over segments of a plane, to find contacts and what lies below a point.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

struct Segment2 {
    Vec2 a, b;
};

// It is built once over segments in the given order. Any order is correct. It is fast when neighbours in the order are
// neighbours in the plane, as along a contour. A query then costs O(log n + hits), and all pairs O(n log n + pairs).
class SegmentIndex {
  public:
    explicit SegmentIndex(std::vector<Segment2> segments);

    const std::vector<Segment2>& segments() const { return segments_; }

    // Calls visit(i, j) once for every pair i < j of segments whose boxes meet, until it returns false.
    template <class Visit>
    void for_each_near_pair(Visit&& visit) const;

    // Appends the segments strictly below `point`, crossed by the ray from it towards -y, in ascending order. A
    // segment is half-open in x, so a chain through a vertex on the ray counts once. Segments through the point
    // itself do not count. Exact.
    void below(Vec2 point, std::vector<std::uint32_t>& found) const;

  private:
    // A leaf of the tree has so many segments. [segments; > 0; B]
    static constexpr std::uint32_t leaf_size = 4;

    // Node n of the complete binary tree covers nodes 2n + 1 and 2n + 2; the last `leaf_count_` are leaves.
    bool is_leaf(std::uint32_t node) const { return node + 1 >= leaf_count_; }
    static bool meet(const Box2& p, const Box2& q) {
        return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y;
    }
    static Box2 box_of(const Segment2& segment) {
        Box2 box;
        box.extend(segment.a);
        box.extend(segment.b);
        return box;
    }
    std::pair<std::uint32_t, std::uint32_t> range(std::uint32_t leaf) const;
    template <class Visit>
    bool visit_leaf_pair(std::uint32_t p, std::uint32_t q, Visit& visit) const;

    std::vector<Segment2> segments_;
    std::vector<Box2> nodes_;
    std::uint32_t leaf_count_ = 0;  // a power of two, 0 without segments
};

template <class Visit>
bool SegmentIndex::visit_leaf_pair(std::uint32_t p, std::uint32_t q, Visit& visit) const {
    const auto [p_begin, p_end] = range(p);
    const auto [q_begin, q_end] = range(q);
    for (std::uint32_t i = p_begin; i < p_end; ++i) {
        const Box2 box = box_of(segments_[i]);
        for (std::uint32_t j = p == q ? i + 1 : q_begin; j < q_end; ++j) {
            if (meet(box, box_of(segments_[j])) && !visit(i, j)) return false;
        }
    }
    return true;
}

template <class Visit>
void SegmentIndex::for_each_near_pair(Visit&& visit) const {
    if (nodes_.empty()) return;
    // Pairs of nodes (p, q) on one level with p <= q, so that i < j holds for every pair visited.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> open{{0, 0}};
    while (!open.empty()) {
        const auto [p, q] = open.back();
        open.pop_back();
        if (!meet(nodes_[p], nodes_[q])) continue;
        if (is_leaf(p)) {
            if (!visit_leaf_pair(p, q, visit)) return;
            continue;
        }
        const std::uint32_t p_low = 2 * p + 1, p_high = 2 * p + 2, q_low = 2 * q + 1, q_high = 2 * q + 2;
        open.push_back({p_high, q_high});
        if (p != q) open.push_back({p_high, q_low});
        open.push_back({p_low, q_high});
        open.push_back({p_low, q_low});
    }
}

}  // namespace anatomesh
