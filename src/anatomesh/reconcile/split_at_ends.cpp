#include "anatomesh/reconcile/split_at_ends.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/reconcile/contour_graph.h"
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
    std::vector<Vec3> points;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges(set.contours.size());
    for (const Slice& slice : set.slices) {
        std::vector<PlaneRing> rings;
        std::vector<std::vector<Vec3>> fresh;
        for (const Contour& contour : set.contours_of(slice)) {
            fresh.push_back(with_splits(set, contour, splits, least_mm));
            PlaneRing ring{contour.structure, {}};
            for (const Vec3& p : fresh.back()) ring.at.push_back(slice.plane.to_plane(p));
            rings.push_back(std::move(ring));
        }
        const bool sound = slice_faults(rings, set.exclusive).empty();
        for (std::uint32_t n = 0; n < slice.contour_count; ++n) {
            const std::uint32_t c = slice.first_contour + n;
            const auto old = set.points_of(set.contours[c]);
            if (!sound) fresh[n].assign(old.begin(), old.end());
            ranges[c] = {static_cast<std::uint32_t>(points.size()),
                         static_cast<std::uint32_t>(fresh[n].size())};
            points.insert(points.end(), fresh[n].begin(), fresh[n].end());
        }
    }
    const std::size_t added = points.size() - set.points.size();
    for (std::size_t c = 0; c < ranges.size(); ++c) {
        set.contours[c].first_point = ranges[c].first;
        set.contours[c].point_count = ranges[c].second;
    }
    set.points = std::move(points);
    return added;
}

}  // namespace anatomesh
