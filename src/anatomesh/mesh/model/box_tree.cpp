#include "anatomesh/mesh/model/box_tree.h"

#include <algorithm>
#include <array>
#include <utility>

#include "anatomesh/base/parallel.h"

namespace anatomesh {

namespace {

struct Item {
    std::array<double, 3> center;  // three times the center
    std::uint32_t triangle;
};

std::size_t longest_axis(std::span<const Item> items) {
    std::array<double, 3> low = items[0].center, high = items[0].center;
    for (const Item& item : items) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], item.center[axis]);
            high[axis] = std::max(high[axis], item.center[axis]);
        }
    }
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
        if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
    }
    return longest;
}

}  // namespace

BoxTree make_box_tree(std::span<const Vec3> points, std::span<const Triangle> triangles, int threads) {
    BoxTree tree;
    if (triangles.empty()) return tree;
    std::vector<Item> items(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Triangle& f = triangles[t];
        const Vec3 sum = points[f[0]] + points[f[1]] + points[f[2]];
        items[t] = {{sum.x, sum.y, sum.z}, static_cast<std::uint32_t>(t)};
    }
    tree.nodes.push_back({{}, 0, static_cast<std::uint32_t>(items.size())});
    // Breadth first: children come after their parents, so boxes can be gathered from the back.
    const auto halve = [&](const BoxTree::Node& node) {
        if (node.count <= BoxTree::leaf_size) return;
        const auto begin = items.begin() + node.first;
        const std::size_t axis = longest_axis({items.data() + node.first, node.count});
        std::nth_element(begin, begin + node.count / 2, begin + node.count,
                         [axis](const Item& a, const Item& b) {
                             if (a.center[axis] != b.center[axis]) return a.center[axis] < b.center[axis];
                             return a.triangle < b.triangle;
                         });
    };
    for (std::size_t level = 0; level < tree.nodes.size();) {
        const std::size_t end = tree.nodes.size();
        // Nodes of a level hold about as many triangles each.
        const std::size_t grain = std::max<std::size_t>(1, 4096 / tree.nodes[level].count);
        parallel_for(end - level, grain, threads, [&](std::size_t first, std::size_t last) {
            for (std::size_t n = first; n < last; ++n) halve(tree.nodes[level + n]);
        });
        for (; level < end; ++level) {
            const std::uint32_t first = tree.nodes[level].first, count = tree.nodes[level].count;
            if (count <= BoxTree::leaf_size) continue;
            tree.nodes[level].first = static_cast<std::uint32_t>(tree.nodes.size());
            tree.nodes[level].count = 0;
            tree.nodes.push_back({{}, first, count / 2});
            tree.nodes.push_back({{}, first + count / 2, count - count / 2});
        }
    }
    tree.order.reserve(items.size());
    for (const Item& item : items) tree.order.push_back(item.triangle);
    for (std::size_t n = tree.nodes.size(); n-- > 0;) {
        BoxTree::Node& node = tree.nodes[n];
        if (node.count == 0) {
            for (const std::uint32_t child : {node.first, node.first + 1}) {
                node.box.extend(tree.nodes[child].box.low);
                node.box.extend(tree.nodes[child].box.high);
            }
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            for (const std::uint32_t v : triangles[tree.order[i]]) node.box.extend(points[v]);
        }
    }
    return tree;
}

MeetingPairs::MeetingPairs(const BoxTree& tree, std::span<const Vec3> points,
                           std::span<const Triangle> triangles)
    : tree_(tree) {
    boxes_.reserve(tree.order.size());
    for (const std::uint32_t t : tree.order) boxes_.push_back(triangle_box(points, triangles[t]));
}

// A pair of nodes of which one is no leaf, as pairs of their children.
void MeetingPairs::part(std::uint32_t a, std::uint32_t b, std::vector<NodePair>& parts) const {
    const BoxTree::Node &one = tree_.nodes[a], &two = tree_.nodes[b];
    if (a == b) {
        parts.push_back({one.first, one.first});
        parts.push_back({one.first + 1, one.first + 1});
        parts.push_back({one.first, one.first + 1});
    } else if (two.count > 0 || (one.count == 0 && one.box.diagonal() >= two.box.diagonal())) {
        parts.push_back({one.first, b});
        parts.push_back({one.first + 1, b});
    } else {
        parts.push_back({a, two.first});
        parts.push_back({a, two.first + 1});
    }
}

std::vector<NodePair> MeetingPairs::pieces(std::size_t wanted) const {
    std::vector<NodePair> pieces;
    if (!tree_.nodes.empty()) pieces.push_back({0, 0});
    for (bool parted = true; parted && pieces.size() < wanted;) {
        parted = false;
        std::vector<NodePair> next;
        for (const auto& [a, b] : pieces) {
            const BoxTree::Node &one = tree_.nodes[a], &two = tree_.nodes[b];
            if (a != b && !boxes_meet(one.box, two.box)) continue;
            if (one.count > 0 && two.count > 0) {
                next.push_back({a, b});
            } else {
                part(a, b, next);
                parted = true;
            }
        }
        pieces = std::move(next);
    }
    return pieces;
}

}  // namespace anatomesh
