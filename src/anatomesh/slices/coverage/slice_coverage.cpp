#include "anatomesh/slices/coverage/slice_coverage.h"

#include <algorithm>
#include <numeric>

#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/sweep.h"
#include "anatomesh/slices/coverage/covering_slices.h"

namespace anatomesh {

namespace {

// The slices in the order in which they lie, and their heights, if they are a stack or a sweep.
struct InOrder {
    std::vector<std::uint32_t> slices;
    std::vector<double> heights;  // empty: not known
    Vec3 middle, way;             // these are along it, from there
};

InOrder in_order(const ContourSet& set) {
    InOrder result;
    result.slices.resize(set.slices.size());
    std::iota(result.slices.begin(), result.slices.end(), 0u);
    if (set.slices.empty() || !(is_parallel(set) || Sweep::of(set))) return result;
    const Box3 box = set.box();
    result.middle = 0.5 * (box.low + box.high);
    result.way = set.slices.front().plane.normal;
    std::vector<double> at;
    for (const Slice& slice : set.slices)
        at.push_back(-slice.plane.signed_distance(result.middle) / dot(slice.plane.normal, result.way));
    std::stable_sort(result.slices.begin(), result.slices.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return at[a] < at[b]; });
    for (const std::uint32_t s : result.slices) result.heights.push_back(at[s]);
    return result;
}

}  // namespace

std::vector<bool> slice_coverage(const ContourSet& set, std::uint32_t structure) {
    std::vector<bool> tell(set.slices.size(), true);
    if (set.overlapping) {
        const OverlappingContours& all = *set.overlapping;
        for (std::size_t n = 0; n < all.levels.size(); ++n) {
            const ContourSet& level = all.levels[n];
            for (std::uint32_t s = 0; s < level.structures.size(); ++s) {
                if (level.structures[s].number != set.structures[structure].number) continue;
                const std::vector<bool> by_level = slice_coverage(level, s);
                tell.assign(tell.size(), false);
                for (std::size_t k = 0; k < by_level.size(); ++k) tell[all.slices[n][k]] = by_level[k];
                return tell;
            }
        }
    }
    if (set.exclusive) return tell;
    const InOrder order = in_order(set);
    std::vector<std::uint32_t> drawn;
    for (std::uint32_t n = 0; n < order.slices.size(); ++n) {
        const auto all = set.contours_of(set.slices[order.slices[n]]);
        if (std::any_of(all.begin(), all.end(), [&](const Contour& c) { return c.structure == structure; }))
            drawn.push_back(n);
    }
    if (drawn.empty()) return tell;
    const std::vector<std::uint32_t> covering =
        covering_slices(drawn, order.heights, heights_left_out(set, structure, order.middle, order.way));
    if (covering.size() == drawn.back() - drawn.front() + 1u) return tell;
    tell.assign(tell.size(), false);
    for (const std::uint32_t n : covering) tell[order.slices[n]] = true;
    return tell;
}

}  // namespace anatomesh
