// For tests: one slice of a contour set from polygons in its plane.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh::fixtures {

using Polygon = std::vector<Vec2>;

struct Drawing {
    std::uint32_t structure;
    Polygon polygon;  // outer ones counter-clockwise, holes clockwise
};

inline ContourSet slice_of(const std::vector<Drawing>& drawings,
                           const Plane& plane = make_plane({}, {0, 0, 1})) {
    ContourSet set;
    set.slices = {{plane, 0, static_cast<std::uint32_t>(drawings.size()), "0"}};
    for (const Drawing& drawing : drawings) {
        while (set.structures.size() <= drawing.structure)
            set.structures.push_back({static_cast<std::int32_t>(set.structures.size() + 1), "", {}});
        std::vector<Vec3> points;
        for (const Vec2 p : drawing.polygon) points.push_back(plane.to_space(p));
        std::rotate(points.begin(),
                    std::min_element(points.begin(), points.end(),
                                     [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); }),
                    points.end());
        set.contours.push_back({drawing.structure, 0, static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(points.size())});
        set.points.insert(set.points.end(), points.begin(), points.end());
    }
    return set;
}

}  // namespace anatomesh::fixtures
