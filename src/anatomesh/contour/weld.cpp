#include "anatomesh/contour/weld.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "anatomesh/geom/point_grid.h"

namespace anatomesh {

WeldStats weld_contours(ContourSet& set, double tolerance_mm) {
    WeldStats stats;
    PointGrid kept(2 * tolerance_mm, set.points.size());
    std::vector<std::uint32_t> user;  // the last contour that uses each kept point
    for (std::uint32_t contour = 0; contour < set.contours.size(); ++contour) {
        const Contour& c = set.contours[contour];
        for (std::uint32_t n = c.first_point; n < c.first_point + c.point_count; ++n) {
            Vec3& p = set.points[n];
            // The nearest kept point that this contour does not use yet; the first of equally near ones.
            std::uint32_t nearest = 0;
            double least = INFINITY;
            kept.for_each_within(p, tolerance_mm, [&](std::uint32_t k, double squared) {
                if (user[k] == contour || squared > least || (squared == least && k > nearest)) return;
                nearest = k;
                least = squared;
            });
            if (least == INFINITY) {
                kept.add(p);
                user.push_back(contour);
                continue;
            }
            user[nearest] = contour;
            if (least == 0) continue;
            ++stats.moved;
            stats.max_displacement_mm = std::max(stats.max_displacement_mm, std::sqrt(least));
            p = kept.point(nearest);
        }
    }
    return stats;
}

}  // namespace anatomesh
