// Planes that cross each other, and their sections through a tetrahedron.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh {

struct CrossingPlanes {
    std::span<const Plane> planes;
    std::span<const Box2> extents;  // of each, in it: it ends there
    double on_plane_mm = 0;         // vertices this near to a plane lie in it. >= 0

    bool empty() const { return planes.empty(); }
};

// The section of a plane through a tetrahedron, or a facet that lies in the plane.
struct PlaneSection {
    static constexpr int no_facet = 4;  // A tetrahedron has the facets 0 to 3. [facet; 4; D]

    double area = 0;       // mm^2; 0: there is none
    Vec3 middle;           // the mean of its corners
    int facet = no_facet;  // the number of the vertex opposite the facet
};

inline double triangle_area(Vec3 a, Vec3 b, Vec3 c) {
    return 0.5 * length(cross(b - a, c - a));
}

// `heights` are those of the corners above the plane, in mm, and 0 for corners that lie in it.
PlaneSection section_at(const std::array<Vec3, 4>& corners, const std::array<double, 4>& heights);

// Calls visit(number of the plane, section) for each plane whose extent holds the middle of its section, by rising
// numbers. O(planes).
template <class Visit>
void for_each_section(const std::array<Vec3, 4>& corners, const CrossingPlanes& crossing,
                      const Visit& visit) {
    double reach = 0;
    for (const Vec3& q : corners) reach = std::max(reach, squared_length(q - corners[0]));
    reach = std::sqrt(reach);
    for (std::uint32_t k = 0; k < crossing.planes.size(); ++k) {
        const Plane& plane = crossing.planes[k];
        if (std::abs(plane.signed_distance(corners[0])) > reach) continue;
        std::array<double, 4> heights{};
        for (std::size_t i = 0; i < 4; ++i) {
            heights[i] = plane.signed_distance(corners[i]);
            if (std::abs(heights[i]) <= crossing.on_plane_mm) heights[i] = 0;
        }
        const PlaneSection section = section_at(corners, heights);
        if (section.area > 0 && crossing.extents[k].contains(plane.to_plane(section.middle)))
            visit(k, section);
    }
}

}  // namespace anatomesh
