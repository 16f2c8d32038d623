#include "anatomesh/reconcile/move/reindex_points.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <utility>

namespace anatomesh {

void reindex_points(ContourSet& set, std::span<const std::vector<Vec3>> of_contours) {
    assert(of_contours.size() == set.contours.size());
    std::vector<Vec3> points;
    for (std::size_t c = 0; c < of_contours.size(); ++c) {
        set.contours[c].first_point = static_cast<std::uint32_t>(points.size());
        set.contours[c].point_count = static_cast<std::uint32_t>(of_contours[c].size());
        points.insert(points.end(), of_contours[c].begin(), of_contours[c].end());
    }
    set.points = std::move(points);
}

std::optional<ContourSet> in_order_of(const ContourSet& order, const ContourSet& set) {
    const auto less = [](Vec3 p, Vec3 q) { return lexicographic_less(p, q); };
    ContourSet result = set;
    for (std::size_t c = 0; c < order.contours.size(); ++c) {
        const Contour& now = order.contours[c];
        const auto own = order.points_of(now);
        std::vector<Vec3> points(own.begin(), own.end());
        std::sort(points.begin(), points.end(), less);
        const std::span<const Contour> slice = set.contours_of(set.slices[now.slice]);
        const auto was = std::find_if(slice.begin(), slice.end(), [&](const Contour& contour) {
            if (contour.structure != now.structure) return false;
            const auto all = set.points_of(contour);
            return std::any_of(all.begin(), all.end(), [&](const Vec3& p) {
                return std::binary_search(points.begin(), points.end(), p, less);
            });
        });
        if (was == slice.end()) return std::nullopt;
        result.contours[c] = *was;
    }
    return result;
}

}  // namespace anatomesh
