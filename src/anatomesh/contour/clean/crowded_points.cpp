#include "anatomesh/contour/clean/crowded_points.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <span>
#include <utility>

#include "anatomesh/contour/simplify/simplify.h"

namespace anatomesh {

namespace {

std::vector<Vec3> sorted(std::vector<Vec3> points) {
    std::sort(points.begin(), points.end(), LexicographicLess{});
    return points;
}

}  // namespace

bool has_crowded(const ContourSet& set, double nearer_mm) {
    return std::any_of(set.contours.begin(), set.contours.end(), [&](const Contour& contour) {
        const std::span<const Vec3> points = set.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            if (length(points[(n + 1) % points.size()] - points[n]) < nearer_mm) return true;
        }
        return false;
    });
}

Result<CrowdedPoints> leave_out_crowded(ContourSet set, const CrowdedOptions& options, RunContext& context) {
    assert(options.nearer_mm >= 0);
    if (options.nearer_mm == 0 || !has_crowded(set, options.nearer_mm))
        return CrowdedPoints{std::move(set), {}};
    assert(options.within_mm > 0 && options.within_mm <= options.nearer_mm);
    SimplifyOptions simplifying;
    simplifying.epsilon_mm = options.within_mm;
    simplifying.crowded_mm = options.nearer_mm;
    ANATOMESH_TRY(SimplifyResult thin, simplify_contours(set, simplifying, context));
    CrowdedPoints result{std::move(thin.kept), {}, thin.stats.max_distance_mm};
    const std::vector<Vec3> before = sorted(std::move(set.points)), after = sorted(result.kept.points);
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(),
                        std::back_inserter(result.left_out), LexicographicLess{});
    return result;
}

}  // namespace anatomesh
