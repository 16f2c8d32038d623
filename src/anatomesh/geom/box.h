// Axis-parallel boxes. A default box is empty: it contains nothing and grows from any point.
#pragma once

#include <algorithm>
#include <limits>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

struct Box2 {
    Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    Vec2 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    bool empty() const { return !(low.x <= high.x && low.y <= high.y); }
    void extend(Vec2 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    bool contains(Vec2 p) const { return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y; }
    Box2 grown(double margin) const {
        return {{low.x - margin, low.y - margin}, {high.x + margin, high.y + margin}};
    }
};

struct Box3 {
    Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
             std::numeric_limits<double>::infinity()};
    Vec3 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
              -std::numeric_limits<double>::infinity()};

    bool empty() const { return !(low.x <= high.x && low.y <= high.y && low.z <= high.z); }
    void extend(Vec3 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    bool contains(Vec3 p) const {
        return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z &&
               p.z <= high.z;
    }
    Box3 grown(double margin) const {
        return {low - Vec3{margin, margin, margin}, high + Vec3{margin, margin, margin}};
    }
    double diagonal() const { return empty() ? 0.0 : length(high - low); }
};

// Whether the boxes have a point in common; their faces belong to them.
inline bool meet(const Box3& p, const Box3& q) {
    return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y &&
           p.low.z <= q.high.z && q.low.z <= p.high.z;
}

}  // namespace anatomesh
