#include "anatomesh/field/motion/nested_outlines.h"

#include <cmath>

#include "anatomesh/field/motion/outlines.h"

namespace anatomesh {

namespace {

// Outlines whose radii differ by less find their pieces by the usual search; from here on some pieces find
// nothing within search_reach. [gaps; 0 to search_reach; M 2026-11 head CT, every second slice out]
constexpr double least_difference = 3.1;
// Of two such outlines, pieces are matched within so many differences of their radii: an outline need not lie
// in the middle of the other. [differences of radii; >= 1; M 2026-11 head CT, every second slice out]
constexpr double reach_share = 2;
// Whether an outline besides `own` has a share in the ring between two.
bool has_third(const Outlines& outlines, std::uint32_t own, const Outlines& in_inner, const Outline& inner,
               const Outlines& in_outer, const Outline& outer) {
    for (std::uint32_t n = 0; n < outlines.size(); ++n) {
        if (n == own || !are_near(outlines[n], outer)) continue;
        if (share_within(outlines, outlines[n], in_outer, outer) != Share::none) return true;
        if (share_within(in_inner, inner, outlines, outlines[n]) != Share::none) return true;
    }
    return false;
}

}  // namespace

std::pair<std::vector<NestedOutline>, std::vector<NestedOutline>> nested_outlines(const Boundary& below,
                                                                                  const Boundary& above,
                                                                                  double gap) {
    std::vector<NestedOutline> in_below(below.outlines), in_above(above.outlines);
    const Outlines lower(below), upper(above);
    for (std::uint32_t i = 0; i < lower.size(); ++i) {
        for (std::uint32_t j = 0; j < upper.size(); ++j) {
            const double difference = std::abs(lower[i].radius - upper[j].radius);
            if (difference < least_difference * gap || !are_near(lower[i], upper[j])) continue;
            const bool shrinks = upper[j].radius < lower[i].radius;
            const Outlines &in_outer = shrinks ? lower : upper, &in_inner = shrinks ? upper : lower;
            const Outline &outer = in_outer[shrinks ? i : j], &inner = in_inner[shrinks ? j : i];
            if (share_within(in_inner, inner, in_outer, outer) != Share::all ||
                has_third(lower, i, in_inner, inner, in_outer, outer) ||
                has_third(upper, j, in_inner, inner, in_outer, outer))
                continue;
            in_below[i] = {j, reach_share * difference};
            in_above[j] = {i, reach_share * difference};
        }
    }
    return {std::move(in_below), std::move(in_above)};
}

}  // namespace anatomesh
