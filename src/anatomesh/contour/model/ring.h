// Ring: one closed polygon on a slice while contours are cleaned, and the repairs of a ring by itself.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/geom/plane.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// at[i] is always Plane::to_plane(points[i]), so that what is decided on the one holds for the other.
struct Ring {
    std::vector<Vec2> at;
    std::vector<Vec3> points;
    std::uint32_t source = 0;  // the contour it came from; combined rings: the smallest
    std::int32_t plane = -1;   // the declared plane it came on, if any

    std::size_t size() const { return at.size(); }
    void push_back(Vec2 in_plane, Vec3 in_space) {
        at.push_back(in_plane);
        points.push_back(in_space);
    }
};

Ring make_ring(std::vector<Vec3> points, const Plane& plane, std::uint32_t source);

// Drops points equal to their predecessor in the cycle, and returns how many. One is left of equal ones. O(n).
std::size_t drop_repeated_points(std::vector<Vec3>& points);

// Turns and, if need be, reverses the cycle so that its sequence of points is the lexicographically smallest. It
// finds the least rotation with two pointers (Shiloach, J. Algorithms 2, 1981). O(n).
void canonicalize_cycle(std::vector<Vec3>& points);

// Removes every vertex at which the ring turns back on itself exactly, which is a spike or a hair of width 0, and
// repeated points that this leaves. Returns how many were removed. The region does not change and no kept vertex
// moves. A ring that is one stroke out and back ends with fewer than three vertices. O(n).
std::size_t remove_spikes(Ring& ring);

// Reverses the direction; vertex 0 stays first.
void reverse_ring(Ring& ring);

}  // namespace anatomesh
