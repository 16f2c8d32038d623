#include "anatomesh/overlaps/nesting.h"

#include <algorithm>
#include <utility>

#include "anatomesh/geom/box.h"
#include "anatomesh/overlaps/slice_partition.h"
#include "anatomesh/slices/coverage/covering_slices.h"

namespace anatomesh {

namespace {

// Rule 3: so much of a structure's area lies in the other one. [1; 0 to 1; M 2026-11 random solids]
constexpr double nested_share = 0.5;
// Rule 4: so much of its outline may run along the other one's. [1; 0 to 1; M 2026-11 a heart, 23 frames]
constexpr double most_shared = 0.1;
// Rule 5: so much of its area it may give to one of another level beside it. [1; 0 to 1; M 2026-11, set not
// recorded]
constexpr double most_across = 0.02;

// Decides by rules 3, 4 and 6 of give_overlaps(). A slice between the structure's own that draws the outer
// one alone takes the room from it that it has between its slices; then only its whole drawing counts.
bool lies_in(std::uint32_t s, std::uint32_t outer, const Relations& relations,
             const std::vector<std::uint32_t>& rank) {
    const Relation &here = relations.of(s, outer), &whole = relations.of(s, s);
    const auto lies = [&](double area, double perimeter, double area_of_outer) {
        return area <= area_of_outer && here.common > least_overlap_mm2 &&
               here.common >= nested_share * area && here.shared <= most_shared * perimeter;
    };
    return rank[s] < rank[outer] &&
           ((!here.between && lies(whole.area, whole.perimeter, relations.of(outer, outer).area)) ||
            (!here.alone && lies(here.area, here.perimeter, relations.of(outer, s).area)));
}

bool overlap(const Box3& p, const Box3& q) {
    return p.low.x <= q.high.x && q.low.x <= p.high.x && p.low.y <= q.high.y && q.low.y <= p.high.y &&
           p.low.z <= q.high.z && q.low.z <= p.high.z;
}

std::vector<Box3> boxes_of(const ContourSet& set) {
    std::vector<Box3> boxes(set.structures.size());
    for (const Contour& contour : set.contours) {
        for (const Vec3& p : set.points_of(contour)) boxes[contour.structure].extend(p);
    }
    return boxes;
}

// Returns one slice with what it draws of a structure and what slice `beside` draws of another one, moved
// onto its plane.
ContourSet together(const ContourSet& set, std::uint32_t slice, std::uint32_t structure, std::uint32_t beside,
                    std::uint32_t other) {
    ContourSet both;
    both.structures = set.structures;
    const Plane& plane = set.slices[slice].plane;
    for (const auto& [from, drawn] : {std::pair{slice, structure}, std::pair{beside, other}}) {
        for (Contour contour : set.contours_of(set.slices[from])) {
            if (contour.structure != drawn) continue;
            const auto points = set.points_of(contour);
            contour.slice = 0;
            contour.first_point = static_cast<std::uint32_t>(both.points.size());
            for (const Vec3& p : points) both.points.push_back(plane.to_space(plane.to_plane(p)));
            both.contours.push_back(contour);
        }
    }
    both.slices.push_back(
        {plane, 0, static_cast<std::uint32_t>(both.contours.size()), set.slices[slice].name});
    return both;
}

}  // namespace

void note_alone(const ContourSet& set, Relations& relations) {
    const auto count = static_cast<std::uint32_t>(set.structures.size());
    const bool in_order = all_parallel(set, parallel_tolerance_mm);
    std::vector<std::vector<bool>> draws(set.slices.size(), std::vector<bool>(count, false));
    for (const Contour& contour : set.contours) draws[contour.slice][contour.structure] = true;
    for (std::uint32_t s = 0; s < count; ++s) {
        const auto has = [&](const std::vector<bool>& slice) { return slice[s]; };
        auto first = std::find_if(draws.begin(), draws.end(), has);
        auto last = std::find_if(draws.rbegin(), draws.rend(), has).base();
        if (!in_order) first = draws.begin(), last = draws.end();
        for (auto slice = first; slice < last; ++slice) {
            for (std::uint32_t t = 0; t < count; ++t) {
                if (!(*slice)[s] && (*slice)[t]) relations.of(s, t).alone = true;
            }
        }
    }
}

void relate_between(const ContourSet& set, const std::vector<std::uint32_t>& rank, Relations& relations) {
    const auto count = static_cast<std::uint32_t>(set.structures.size());
    const std::vector<Box3> boxes = boxes_of(set);
    std::vector<std::vector<std::uint32_t>> drawn(count);
    for (const Contour& contour : set.contours) {
        if (drawn[contour.structure].empty() || drawn[contour.structure].back() != contour.slice)
            drawn[contour.structure].push_back(contour.slice);
    }
    for (std::uint32_t s = 0; s < count; ++s) {
        for (std::uint32_t t = 0; t < count; ++t) {
            if (s == t || relations.of(s, t).perimeter > 0 || !overlap(boxes[s], boxes[t])) continue;
            Relations found(count);
            for (const std::uint32_t slice : drawn[s]) {
                const auto above = std::upper_bound(drawn[t].begin(), drawn[t].end(), slice);
                if (above == drawn[t].begin() || above == drawn[t].end()) continue;
                for (const std::uint32_t beside : {*(above - 1), *above}) {
                    const ContourSet both = together(set, slice, s, beside, t);
                    SlicePartition partition(both, both.slices[0], rank);
                    if (partition.arrange_contours()) partition.add_to(found);
                }
            }
            if (found.of(s, t).common <= least_overlap_mm2 && found.of(s, t).shared == 0) continue;
            for (const auto& [p, q] : {std::pair{s, t}, std::pair{t, s}}) {
                Relation& relation = relations.of(p, q);
                const Relation& here = found.of(p, q);
                relation.common = 0.5 * here.common;
                relation.shared = 0.5 * here.shared;
                relation.area = 0.5 * here.area;
                relation.perimeter = 0.5 * here.perimeter;
                relation.between = true;
            }
        }
    }
}

std::vector<std::uint32_t> levels_of(const Relations& relations, const std::vector<std::uint32_t>& rank) {
    std::vector<std::uint32_t> by_rank(rank.size()), level(rank.size(), 0);
    for (std::uint32_t s = 0; s < rank.size(); ++s) by_rank[rank[s]] = s;
    // The levels of what a structure may lie in are needed first; it comes later in the order.
    for (std::size_t n = by_rank.size(); n-- > 0;) {
        const std::uint32_t s = by_rank[n];
        for (std::size_t m = n + 1; m < by_rank.size(); ++m) {
            if (lies_in(s, by_rank[m], relations, rank)) level[s] = std::max(level[s], level[by_rank[m]] + 1);
        }
    }
    return level;
}

bool gives_much_across(const Relations& relations, const std::vector<std::uint32_t>& rank,
                       const std::vector<std::uint32_t>& level) {
    for (std::uint32_t s = 0; s < rank.size(); ++s) {
        for (std::uint32_t t = 0; t < rank.size(); ++t) {
            if (rank[t] < rank[s] && level[t] != level[s] && !lies_in(t, s, relations, rank) &&
                relations.of(s, t).common > most_across * relations.of(s, s).area)
                return true;
        }
    }
    return false;
}

bool have_walls(const ContourSet& set, const std::vector<std::uint32_t>& structures,
                const Relations& relations) {
    const std::vector<Box3> boxes = boxes_of(set);
    for (const std::uint32_t s : structures) {
        for (const std::uint32_t t : structures) {
            const Relation& relation = relations.of(s, t);
            if (s == t) continue;
            if (relation.common > least_overlap_mm2 || relation.shared > 0 ||
                (relation.perimeter == 0 && overlap(boxes[s], boxes[t])))
                return true;
        }
    }
    return false;
}

}  // namespace anatomesh
