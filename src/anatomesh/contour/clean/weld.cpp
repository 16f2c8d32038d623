#include "anatomesh/contour/clean/weld.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "anatomesh/geom/point_grid.h"

namespace anatomesh {

WeldStats weld_contours(ContourSet& set, double tolerance_mm) {
    WeldStats stats;
    PointGrid kept(2 * tolerance_mm, set.points.size());
    // The last structure that uses each kept point; the contours of a slice come by structure.
    std::vector<std::uint32_t> user;
    for (const Contour& c : set.contours) {
        for (std::uint32_t n = c.first_point; n < c.first_point + c.point_count; ++n) {
            Vec3& p = set.points[n];
            // The nearest kept point that this structure does not use yet; the first of equally near ones.
            std::uint32_t nearest = 0;
            double least = INFINITY;
            kept.for_each_within(p, tolerance_mm, [&](std::uint32_t k, double squared) {
                if (user[k] == c.structure || squared > least || (squared == least && k > nearest)) return;
                nearest = k;
                least = squared;
            });
            if (least == INFINITY) {
                kept.add(p);
                user.push_back(c.structure);
                continue;
            }
            user[nearest] = c.structure;
            if (least == 0) continue;
            ++stats.moved;
            stats.max_displacement_mm = std::max(stats.max_displacement_mm, std::sqrt(least));
            p = kept.point(nearest);
        }
    }
    return stats;
}

}  // namespace anatomesh
