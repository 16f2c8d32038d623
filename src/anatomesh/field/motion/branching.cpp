#include "anatomesh/field/motion/branching.h"

#include <algorithm>

#include "anatomesh/base/disjoint_sets.h"
#include "anatomesh/field/motion/outlines.h"

namespace anatomesh {

namespace {

// So many points of an outline, evenly spread, say in which ones of the other slice it lies.
// [points; >= 8; B]
constexpr std::uint32_t outline_points_asked = 128;

std::uint32_t count_solid(const Outlines& outlines) {
    std::uint32_t solid = 0;
    for (std::uint32_t n = 0; n < outlines.size(); ++n) solid += outlines[n].area > 0;
    return solid;
}

// Joins the outlines of one slice with those of the other in which their points lie.
void join_overlapping(const Outlines& outlines, const Outlines& others, const DistanceMap& others_map,
                      std::uint32_t first, std::uint32_t first_other, DisjointSets& groups) {
    for (std::uint32_t n = 0; n < outlines.size(); ++n) {
        const Outline& outline = outlines[n];
        if (!(outline.area > 0)) continue;
        const std::uint32_t stride = outline.count / outline_points_asked + 1;
        outlines.each_piece(outline, [&](std::uint32_t k, const BoundaryPiece& piece) {
            if (k % stride != 0 || !(others_map.value(piece.a) < 0)) return;
            // Of those round the point, the innermost bounds what is drawn there.
            std::uint32_t in = no_piece;
            for (std::uint32_t m = 0; m < others.size(); ++m) {
                const Outline& other = others[m];
                if (other.area > 0 && other.box.contains(piece.a) &&
                    (in == no_piece || other.area < others[in].area) && others.contains(other, piece.a))
                    in = m;
            }
            if (in != no_piece) groups.join(first + n, first_other + in);
        });
    }
}

}  // namespace

std::vector<Ambiguity> ambiguities(const BoundarySide& below, const DistanceMap& below_map,
                                   const BoundarySide& above, const DistanceMap& above_map) {
    const Outlines lower(below.boundary), upper(above.boundary);
    if (count_solid(lower) < 2 || count_solid(upper) < 2) return {};
    const std::uint32_t count = lower.size() + upper.size();
    DisjointSets groups(count);  // of outlines, those above numbered after those below
    join_overlapping(lower, upper, above_map, 0, lower.size(), groups);
    join_overlapping(upper, lower, below_map, lower.size(), 0, groups);
    std::vector<Ambiguity> found(count);
    std::vector<Box2> boxes(count);
    for (std::uint32_t n = 0; n < count; ++n) {
        const bool is_below = n < lower.size();
        const Outline& outline = is_below ? lower[n] : upper[n - lower.size()];
        if (!(outline.area > 0)) continue;
        const std::uint32_t group = groups.root(n);
        ++(is_below ? found[group].below : found[group].above);
        boxes[group].extend(outline.box.low);
        boxes[group].extend(outline.box.high);
    }
    std::vector<Ambiguity> ambiguous;
    for (std::uint32_t n = 0; n < count; ++n) {
        Ambiguity& group = found[n];
        if (group.below < 2 || group.above < 2 || group.below == group.above) continue;
        group.at = 0.5 * (boxes[n].low + boxes[n].high);
        ambiguous.push_back(group);
    }
    return ambiguous;
}

}  // namespace anatomesh
