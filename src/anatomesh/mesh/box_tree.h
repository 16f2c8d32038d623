// BoxTree: a binary tree of boxes over a set of triangles, for pairs that may meet and for the closest point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/mesh/surface_mesh.h"

namespace anatomesh {

// Node 0 is the root. A node is a leaf when count > 0: its triangles are order[first, first + count).
// Otherwise its children are nodes first and first + 1. Boxes are closed and exact (no rounding). Guarantees:
// the same tree for the same triangles; leaves hold at most leaf_size triangles.
struct BoxTree {
    struct Node {
        Box3 box;
        std::uint32_t first = 0, count = 0;
    };
    static constexpr std::uint32_t leaf_size = 4;

    std::vector<Node> nodes;           // empty without triangles
    std::vector<std::uint32_t> order;  // the triangles, those of a leaf side by side
};

// Split at the median of the triangles' centers along the longest axis. Complexity: O(n log n).
BoxTree make_box_tree(std::span<const Vec3> points, std::span<const Triangle> triangles);

inline bool boxes_meet(const Box3& a, const Box3& b) {
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
           a.low.z <= b.high.z && b.low.z <= a.high.z;
}

inline Box3 triangle_box(std::span<const Vec3> points, const Triangle& triangle) {
    Box3 box;
    for (const std::uint32_t v : triangle) box.extend(points[v]);
    return box;
}

// Calls visit(a, b) for every pair of different triangles whose boxes meet, each pair once, in a fixed order.
template <class Visit>
void for_meeting_pairs(const BoxTree& tree, std::span<const Vec3> points, std::span<const Triangle> triangles,
                       const Visit& visit) {
    if (tree.nodes.empty()) return;
    std::vector<Box3> boxes(tree.order.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) boxes[i] = triangle_box(points, triangles[tree.order[i]]);
    struct Pair {
        std::uint32_t a, b;
    };
    std::vector<Pair> stack{{0, 0}};
    while (!stack.empty()) {
        const auto [a, b] = stack.back();
        stack.pop_back();
        const BoxTree::Node &one = tree.nodes[a], &two = tree.nodes[b];
        if (a != b && !boxes_meet(one.box, two.box)) continue;
        if (one.count > 0 && two.count > 0) {
            for (std::uint32_t i = one.first; i < one.first + one.count; ++i) {
                for (std::uint32_t j = a == b ? i + 1 : two.first; j < two.first + two.count; ++j) {
                    if (boxes_meet(boxes[i], boxes[j])) visit(tree.order[i], tree.order[j]);
                }
            }
        } else if (a == b) {
            stack.push_back({one.first, one.first});
            stack.push_back({one.first + 1, one.first + 1});
            stack.push_back({one.first, one.first + 1});
        } else if (two.count > 0 || (one.count == 0 && one.box.diagonal() >= two.box.diagonal())) {
            stack.push_back({one.first, b});
            stack.push_back({one.first + 1, b});
        } else {
            stack.push_back({a, two.first});
            stack.push_back({a, two.first + 1});
        }
    }
}

}  // namespace anatomesh
