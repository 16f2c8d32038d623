// BoxTree: a binary tree of boxes over a set of triangles, for pairs that may meet and for the closest point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// Node 0 is the root. A node is a leaf when count > 0: its triangles are order[first, first + count).
// Otherwise its children are nodes first and first + 1. Boxes are closed and exact (no rounding). Guarantees:
// the same tree for the same triangles; leaves hold at most leaf_size triangles.
struct BoxTree {
    struct Node {
        Box3 box;
        std::uint32_t first = 0, count = 0;
    };
    // A leaf holds no more triangles: fewer make more nodes, more are tested in vain. [triangles; >= 1; B]
    static constexpr std::uint32_t leaf_size = 4;

    std::vector<Node> nodes;           // empty without triangles
    std::vector<std::uint32_t> order;  // the triangles, those of a leaf side by side
};

// Split at the median of the triangles' centers along the longest axis. Complexity: O(n log n).
// The same at any number of threads.
BoxTree make_box_tree(std::span<const Vec3> points, std::span<const Triangle> triangles, int threads = 1);

inline bool boxes_meet(const Box3& a, const Box3& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
           a.low.z <= b.high.z && b.low.z <= a.high.z;
}

inline Box3 triangle_box(std::span<const Vec3> points, const Triangle& triangle) {
    Box3 box;
    for (const std::uint32_t v : triangle) box.extend(points[v]);
    return box;
}

// Two nodes of a tree, or twice the same: the pairs of triangles below them, one from either.
struct NodePair {
    std::uint32_t a, b;
};

// Pairs of triangles whose boxes meet.
class MeetingPairs {
  public:
    // Both must outlive it. `triangles`: those that the tree was made of.
    MeetingPairs(const BoxTree& tree, std::span<const Vec3> points, std::span<const Triangle> triangles);

    // At least `wanted` pieces of the work, unless there is less to do: pairs of nodes with which each pair
    // of different triangles comes up once. In a fixed order.
    std::vector<NodePair> pieces(std::size_t wanted) const;

    // Calls visit(a, b) for every pair of a piece, in a fixed order. Thread-safe.
    template <class Visit>
    void for_each(NodePair piece, const Visit& visit) const {
        std::vector<NodePair> stack{piece};
        while (!stack.empty()) {
            const auto [a, b] = stack.back();
            stack.pop_back();
            const BoxTree::Node &one = tree_.nodes[a], &two = tree_.nodes[b];
            if (a != b && !boxes_meet(one.box, two.box)) continue;
            if (one.count == 0 || two.count == 0) {
                part(a, b, stack);
                continue;
            }
            for (std::uint32_t i = one.first; i < one.first + one.count; ++i) {
                for (std::uint32_t j = a == b ? i + 1 : two.first; j < two.first + two.count; ++j) {
                    if (boxes_meet(boxes_[i], boxes_[j])) visit(tree_.order[i], tree_.order[j]);
                }
            }
        }
    }

  private:
    void part(std::uint32_t a, std::uint32_t b, std::vector<NodePair>& parts) const;

    const BoxTree& tree_;
    std::vector<Box3> boxes_;  // of the triangles, in the tree's order
};

}  // namespace anatomesh
