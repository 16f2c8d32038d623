#include "anatomesh/reconcile/split_at_ends.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/reconcile/contour_graph.h"
#include "anatomesh/reconcile/lay_out_points.h"
#include "anatomesh/reconcile/slice_soundness.h"

namespace anatomesh {

namespace {

struct Split {
    std::uint32_t after = 0;  // point of the set
    double distance = 0;      // from it
    Vec3 at;
};

std::vector<Split> find_splits(const ContourSet& set, std::span<const LineComparison> comparisons) {
    std::vector<Split> splits;
    for (const LineComparison& comparison : comparisons) {
        if (comparison.difference_mm == 0) continue;
        for (const auto* ends : {&comparison.ends_a, &comparison.ends_b}) {
            for (const LineEnd& end : *ends) {
                if (end.from != end.to)
                    splits.push_back({end.from, length(end.at - set.points[end.from]), end.at});
            }
        }
    }
    std::sort(splits.begin(), splits.end(), [](const Split& p, const Split& q) {
        if (p.after != q.after) return p.after < q.after;
        return p.distance != q.distance ? p.distance < q.distance : lexicographic_less(p.at, q.at);
    });
    return splits;
}

// A contour with the splits in it that keep their distance.
std::vector<Vec3> with_splits(const ContourSet& set, const Contour& contour, std::span<const Split> splits,
                              double least_mm) {
    std::vector<Vec3> points;
    auto next = std::lower_bound(splits.begin(), splits.end(), contour.first_point,
                                 [](const Split& split, std::uint32_t k) { return split.after < k; });
    for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
        points.push_back(set.points[k]);
        const Vec3 end = set.points[point_after(contour, k)];
        for (; next != splits.end() && next->after == k; ++next) {
            if (length(next->at - points.back()) >= least_mm && length(next->at - end) >= least_mm)
                points.push_back(next->at);
        }
    }
    return points;
}

}  // namespace

std::size_t split_at_ends(ContourSet& set, std::span<const LineComparison> comparisons, double least_mm) {
    const std::vector<Split> splits = find_splits(set, comparisons);
    std::vector<std::vector<Vec3>> fresh(set.contours.size());
    for (const Slice& slice : set.slices) {
        std::vector<PlaneRing> rings;
        const std::uint32_t end = slice.first_contour + slice.contour_count;
        for (std::uint32_t c = slice.first_contour; c < end; ++c) {
            fresh[c] = with_splits(set, set.contours[c], splits, least_mm);
            PlaneRing ring{set.contours[c].structure, {}};
            for (const Vec3& p : fresh[c]) ring.at.push_back(slice.plane.to_plane(p));
            rings.push_back(std::move(ring));
        }
        if (slice_faults(rings, set.exclusive).empty()) continue;
        for (std::uint32_t c = slice.first_contour; c < end; ++c) {
            const auto old = set.points_of(set.contours[c]);
            fresh[c].assign(old.begin(), old.end());
        }
    }
    const std::size_t before = set.points.size();
    lay_out_points(set, fresh);
    return set.points.size() - before;
}

}  // namespace anatomesh
