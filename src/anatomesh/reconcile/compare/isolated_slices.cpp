#include "anatomesh/reconcile/compare/isolated_slices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace anatomesh {

namespace {

// Planes at a smaller angle are nearly parallel and meet by chance.
// [1, sine; 0 to 1; M 2026-11 long axis 12 to 39 mm beside its ball]
constexpr double least_plane_sine = 0.1;

bool passes_through(const PlanePatch& patch, const Plane& plane) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double x : {patch.box.low.x, patch.box.high.x}) {
        for (const double y : {patch.box.low.y, patch.box.high.y}) {
            const double height = plane.signed_distance(patch.plane.to_space({x, y}));
            low = std::min(low, height), high = std::max(high, height);
        }
    }
    return low < 0 && high > 0;
}

// Returns the gap between the intervals of the two slices on the line: 0 where they overlap, nothing where
// one has none.
std::optional<double> gap_of(const LineComparison& c) {
    std::optional<double> least;
    for (std::size_t i = 0; i + 1 < c.endpoints_a.size(); i += 2) {
        for (std::size_t j = 0; j + 1 < c.endpoints_b.size(); j += 2) {
            const double gap = std::max({c.endpoints_a[i].t - c.endpoints_b[j + 1].t,
                                         c.endpoints_b[j].t - c.endpoints_a[i + 1].t, 0.0});
            least = std::min(least.value_or(gap), gap);
        }
    }
    return least;
}

}  // namespace

std::vector<IsolatedSlice> find_isolated_slices(const ContourSet& set, const std::vector<PlanePatch>& patches,
                                                std::span<const LineComparison> comparisons,
                                                RunContext& context) {
    std::vector<bool> is_met(set.slices.size(), false);
    for (const LineComparison& c : comparisons) {
        if (gap_of(c) == 0.0) is_met[c.a] = is_met[c.b] = true;
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t a = 0; a < set.slices.size(); ++a) {
        for (std::uint32_t b = a + 1; b < set.slices.size(); ++b) {
            if ((is_met[a] && is_met[b]) || set.slices[a].contour_count == 0 ||
                set.slices[b].contour_count == 0)
                continue;
            if (length(cross(patches[a].plane.normal, patches[b].plane.normal)) < least_plane_sine) continue;
            if (passes_through(patches[a], patches[b].plane) && passes_through(patches[b], patches[a].plane))
                pairs.emplace_back(a, b);
        }
    }
    std::vector<IsolatedSlice> found(set.slices.size());
    for (const LineComparison& c :
         compare_planes(set, patches, pairs, std::numeric_limits<double>::infinity(), context)) {
        const std::optional<double> gap = gap_of(c);
        if (!gap) continue;
        if (*gap == 0) is_met[c.a] = is_met[c.b] = true;
        for (const auto& [own, other] : {std::pair(c.a, c.b), std::pair(c.b, c.a)}) {
            IsolatedSlice& isolated = found[own];
            if (isolated.others++ == 0 || *gap < isolated.gap_mm)
                isolated.nearest = other, isolated.gap_mm = *gap;
        }
    }
    std::vector<IsolatedSlice> isolated;
    for (std::uint32_t s = 0; s < found.size(); ++s) {
        if (is_met[s] || found[s].others == 0) continue;
        // A slice that lies elsewhere than many is named, and not each of the many.
        if (found[s].others == 1 && !is_met[found[s].nearest] && found[found[s].nearest].others > 1) continue;
        isolated.push_back(found[s]);
        isolated.back().slice = s;
    }
    return isolated;
}

}  // namespace anatomesh
