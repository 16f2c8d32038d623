#include "anatomesh/contour/overlay/structure_overlap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// A vertex nearer to another structure's wall than this is meant to lie on it. [mm; > 0; D digits of files]
constexpr double near_wall_mm = 1e-3;
// Traced contours of fine pixels come nearer than that, but not so near. [pixels; 0 to 1/64; D trace.h]
constexpr double near_wall_pixels = 1e-3;

using Pair = std::pair<std::uint32_t, std::uint32_t>;

// Structures drawn in a face, by the even-odd rule, ascending.
std::vector<std::uint32_t> drawn_in(const Winding& winding,
                                    const std::vector<std::uint32_t>& structure_of_ring) {
    std::set<std::uint32_t> drawn;
    for (const RingTurns& turns : winding) {
        if (turns.turns % 2 == 0) continue;
        const std::uint32_t structure = structure_of_ring[turns.ring];
        if (!drawn.insert(structure).second) drawn.erase(structure);
    }
    return {drawn.begin(), drawn.end()};
}

// Areas common to two structures; nothing where the contours cross too often.
std::optional<std::map<Pair, double>> common_areas(const ContourSet& set, const Slice& slice) {
    std::vector<Ring> rings;
    std::vector<std::uint32_t> structures;
    for (const Contour& contour : set.contours_of(slice)) {
        const auto points = set.points_of(contour);
        rings.push_back(make_ring({points.begin(), points.end()}, slice.plane,
                                  static_cast<std::uint32_t>(structures.size())));
        structures.push_back(contour.structure);
    }
    const auto graph = arrange(rings, slice.plane, most_arrangement_edges);
    if (!graph) return std::nullopt;
    std::vector<std::vector<std::uint32_t>> drawn;
    for (const Winding& winding : graph->windings) drawn.push_back(drawn_in(winding, structures));
    std::map<Pair, double> common;
    for (const Arrangement::Edge& edge : graph->edges) {
        const Vec2 origin = graph->at[0];
        const double under = 0.5 * cross(graph->at[edge.a] - origin, graph->at[edge.b] - origin);
        for (const auto& [face, sign] : {std::pair{edge.left, 1}, std::pair{edge.right, -1}})
            for (std::size_t a = 0; a < drawn[face].size(); ++a)
                for (std::size_t b = a + 1; b < drawn[face].size(); ++b)
                    common[{drawn[face][a], drawn[face][b]}] += sign * under;
    }
    return common;
}

bool has_several_structures(const ContourSet& set, const Slice& slice) {
    const auto contours = set.contours_of(slice);
    return std::any_of(contours.begin(), contours.end(), [&](const Contour& contour) {
        return contour.structure != contours.front().structure;
    });
}

// The faults between structures: those of an exclusive slice without those that a slice has whatever it is.
std::optional<Pair> meet_amiss(const std::vector<PlaneRing>& rings) {
    const std::vector<RingSegment> faults = slice_faults(rings, true);
    if (faults.size() <= slice_faults(rings, false).size()) return std::nullopt;
    const auto [a, b] = std::minmax(rings[faults[0].ring].structure, rings[faults[1].ring].structure);
    return Pair{a, b};
}

// Two structures with a vertex of the one so near to a segment of the other that it should be a vertex of both.
std::optional<Pair> nearly_meet(const std::vector<PlaneRing>& rings, double near_mm) {
    std::vector<Segment2> segments, padded;
    std::vector<std::uint32_t> structure;
    for (const PlaneRing& ring : rings)
        for (std::size_t i = 0; i < ring.at.size(); ++i) {
            const Vec2 a = ring.at[i], b = ring.at[(i + 1) % ring.at.size()];
            segments.push_back({a, b});
            padded.push_back({{std::min(a.x, b.x) - near_mm, std::min(a.y, b.y) - near_mm},
                              {std::max(a.x, b.x) + near_mm, std::max(a.y, b.y) + near_mm}});
            structure.push_back(ring.structure);
        }
    const auto is_amiss = [&](Vec2 p, const Segment2& s) {
        return !(p == s.a) && !(p == s.b) && distance_to_segment(p, s.a, s.b) < near_mm;
    };
    std::optional<Pair> found;
    SegmentIndex(padded).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
        if (structure[i] == structure[j]) return true;
        const Segment2 &s = segments[i], &t = segments[j];
        if (is_amiss(s.a, t) || is_amiss(s.b, t) || is_amiss(t.a, s) || is_amiss(t.b, s))
            found = Pair{std::min(structure[i], structure[j]), std::max(structure[i], structure[j])};
        return !found;
    });
    return found;
}

}  // namespace

std::optional<StructureOverlap> find_overlap(const ContourSet& set) {
    // Structures with less in common only touch, because crossings are rounded. [mm2; > 0; D rounding of snapped points]
    constexpr double least_mm2 = 1e-6;
    const double near_mm =
        set.pixel_mm > 0 ? std::min(near_wall_mm, near_wall_pixels * set.pixel_mm) : near_wall_mm;
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        const Slice& slice = set.slices[k];
        if (!has_several_structures(set, slice)) continue;
        const auto common = common_areas(set, slice);
        if (common && !common->empty()) {
            const auto most =
                std::max_element(common->begin(), common->end(),
                                 [](const auto& p, const auto& q) { return p.second < q.second; });
            if (most->second > least_mm2)
                return StructureOverlap{k, most->first.first, most->first.second, most->second};
        }
        const std::vector<PlaneRing> rings = plane_rings(set, slice);
        auto pair = meet_amiss(rings);
        if (!pair) pair = nearly_meet(rings, near_mm);
        if (pair) return StructureOverlap{k, pair->first, pair->second, 0};
        if (!common) {
            const auto contours = set.contours_of(slice);
            return StructureOverlap{k, contours.front().structure, contours.back().structure, 0};
        }
    }
    return std::nullopt;
}

}  // namespace anatomesh
