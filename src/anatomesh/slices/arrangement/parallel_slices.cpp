#include "anatomesh/slices/arrangement/parallel_slices.h"

#include <algorithm>

namespace anatomesh {

std::vector<SliceInterval> parallel_intervals(const ContourSet& set, const Plane& frame) {
    std::vector<SliceInterval> intervals;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const double position = frame.signed_distance(set.slices[s].plane.origin);
        SliceInterval interval{s, position, position};
        bool first = true;
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            for (const Vec3& point : set.points_of(contour)) {
                const double z = frame.signed_distance(point);
                interval.low = first ? z : std::min(interval.low, z);
                interval.high = first ? z : std::max(interval.high, z);
                first = false;
            }
        }
        intervals.push_back(interval);
    }
    std::sort(intervals.begin(), intervals.end(), [](const SliceInterval& a, const SliceInterval& b) {
        return a.low != b.low ? a.low < b.low : a.slice < b.slice;
    });
    for (std::size_t i = 0; i + 1 < intervals.size(); ++i) {
        const double gap = middle(intervals[i + 1]) - middle(intervals[i]);
        const double thickest =
            std::max(intervals[i].high - intervals[i].low, intervals[i + 1].high - intervals[i + 1].low);
        if (!(gap > 0) || thickest > 0.1 * gap) return {};
    }
    return intervals;
}

bool is_parallel(const ContourSet& set) {
    return set.slices.empty() || !parallel_intervals(set, set.slices.front().plane).empty();
}

}  // namespace anatomesh
