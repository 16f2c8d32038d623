// Contours put together by the plane that they lie on, before any stack is known.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/planes/plane_grouping.h"
#include "anatomesh/geom/point_scatter.h"

namespace anatomesh {

// Contours that lie on one plane as well as each of them lies on its own.
struct CoplanarCluster {
    std::vector<std::uint32_t> contours;
    double area = 0;   // of all of them
    double noise = 0;  // how far points of one of them lie off that one's own plane
    // Of all points.
    double count = 0;
    Vec3 mean, normal;
    Scatter scatter;

    // How much further off the plane may be at p than at the cluster's own points, for what is known of them.
    double leverage(Vec3 p) const;
};

// The clusters of the contours without a declared plane: the largest first, since a small one alone says little
// of its plane; each goes to the cluster whose plane fits it best, if one does. Points of a contour that lie
// further than `tolerance` off its plane do not show what plane it is. `rounding`: of the points, mm.
// Complexity: O(contours x clusters x points of a cluster) at most.
std::vector<CoplanarCluster> find_coplanar_clusters(std::span<const ContourToPlace> contours,
                                                    double tolerance, double rounding);

}  // namespace anatomesh
