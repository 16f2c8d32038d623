#include "anatomesh/contour/overlay/segment_index.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "anatomesh/geom/predicates.h"

namespace anatomesh {

SegmentIndex::SegmentIndex(std::vector<Segment2> segments) : segments_(std::move(segments)) {
    if (segments_.empty()) return;
    leaf_count_ = std::bit_ceil(static_cast<std::uint32_t>((segments_.size() + leaf_size - 1) / leaf_size));
    nodes_.resize(2 * std::size_t{leaf_count_} - 1);
    for (std::uint32_t leaf = leaf_count_ - 1; leaf < nodes_.size(); ++leaf) {
        const auto [begin, end] = range(leaf);
        for (std::uint32_t i = begin; i < end; ++i) {
            nodes_[leaf].extend(segments_[i].a);
            nodes_[leaf].extend(segments_[i].b);
        }
    }
    for (std::uint32_t node = leaf_count_ - 1; node-- > 0;) {
        for (const Box2& child : {nodes_[2 * node + 1], nodes_[2 * node + 2]}) {
            if (child.empty()) continue;
            nodes_[node].extend(child.low);
            nodes_[node].extend(child.high);
        }
    }
}

std::pair<std::uint32_t, std::uint32_t> SegmentIndex::range(std::uint32_t leaf) const {
    const std::size_t begin = std::size_t{leaf - (leaf_count_ - 1)} * leaf_size;
    return {static_cast<std::uint32_t>(std::min(begin, segments_.size())),
            static_cast<std::uint32_t>(std::min(begin + leaf_size, segments_.size()))};
}

void SegmentIndex::below(Vec2 point, std::vector<std::uint32_t>& found) const {
    if (nodes_.empty()) return;
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
        const std::uint32_t node = open.back();
        open.pop_back();
        const Box2& box = nodes_[node];
        if (!(box.low.x <= point.x && point.x <= box.high.x && box.low.y <= point.y)) continue;
        if (!is_leaf(node)) {
            open.push_back(2 * node + 2);
            open.push_back(2 * node + 1);
            continue;
        }
        const auto [begin, end] = range(node);
        for (std::uint32_t i = begin; i < end; ++i) {
            Vec2 a = segments_[i].a, b = segments_[i].b;
            if ((a.x <= point.x) == (b.x <= point.x)) continue;
            if (a.x > b.x) std::swap(a, b);
            if (orient2d(a, b, point) > 0) found.push_back(i);
        }
    }
}

}  // namespace anatomesh
