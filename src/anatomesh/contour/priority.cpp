#include "anatomesh/contour/priority.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "anatomesh/contour/arrangement.h"
#include "anatomesh/contour/boundary_loops.h"
#include "anatomesh/contour/clean.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr double sliver_width_mm = 1e-3;
constexpr std::size_t most_edges = 20'000'000;
constexpr double least_given_mm2 = 1e-6;  // on a slice
constexpr double nested_share = 0.5;      // of the smaller of two: so much of it in the other

// One slice: an arrangement of all its contours, and which structure owns each of its faces.
class SlicePartition {
  public:
    SlicePartition(const ContourSet& set, const Slice& slice, const std::vector<std::uint32_t>& rank)
        : set_(set), slice_(slice), rank_(rank) {}

    // Nothing when the contours cross too often.
    bool arrange_contours() {
        std::vector<Ring> rings;
        for (const Contour& contour : set_.contours_of(slice_)) {
            const auto points = set_.points_of(contour);
            rings.push_back(make_ring({points.begin(), points.end()}, slice_.plane,
                                      static_cast<std::uint32_t>(structures_.size())));
            structures_.push_back(contour.structure);
        }
        graph_ = arrange(rings, slice_.plane, most_edges);
        if (!graph_) return false;
        for (const Winding& winding : graph_->windings) owners_.push_back(owner_of(winding));
        return true;
    }

    // Adds what the structure keeps to `raw`, and the area of its region in that of each owner to `owned_by`.
    void add_region(std::uint32_t structure, std::int32_t plane, RawContours& raw,
                    std::span<double> owned_by) const {
        std::vector<BoundaryEdge> boundary;
        for (const Arrangement::Edge& edge : graph_->edges) {
            const Vec2 origin = graph_->at[0];
            const double under = 0.5 * cross(graph_->at[edge.a] - origin, graph_->at[edge.b] - origin);
            const bool left = owners_[edge.left].owner == structure,
                       right = owners_[edge.right].owner == structure;
            if (left != right)
                boundary.push_back(left ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
            if (draws(edge.left, structure)) owned_by[owners_[edge.left].owner] += under;
            if (draws(edge.right, structure)) owned_by[owners_[edge.right].owner] -= under;
        }
        std::sort(boundary.begin(), boundary.end(), [](const BoundaryEdge& p, const BoundaryEdge& q) {
            return p.from != q.from ? p.from < q.from : p.to < q.to;
        });
        for (const std::vector<std::uint32_t>& loop : boundary_loops(graph_->at, boundary)) {
            std::vector<Vec2> at;
            for (const std::uint32_t edge : loop) at.push_back(graph_->at[boundary[edge].from]);
            if (2 * std::abs(signed_area(at)) <= sliver_width_mm * perimeter(at)) continue;
            RawContour contour;
            contour.structure = structure;
            contour.first_point = static_cast<std::uint32_t>(raw.points.size());
            contour.point_count = static_cast<std::uint32_t>(loop.size());
            contour.plane = plane;
            contour.name = slice_.name;
            for (const std::uint32_t edge : loop) raw.points.push_back(graph_->points[boundary[edge].from]);
            raw.contours.push_back(contour);
        }
    }

  private:
    static constexpr std::uint32_t nobody = 0xFFFFFFFFu;
    struct Face {
        std::uint32_t owner = nobody;
        std::vector<std::uint32_t> drawn;  // all structures there
    };

    Face owner_of(const Winding& winding) const {
        Face face;
        for (const RingTurns& turns : winding) {
            if (turns.turns % 2 == 0) continue;
            const std::uint32_t structure = structures_[turns.ring];
            const auto found = std::find(face.drawn.begin(), face.drawn.end(), structure);
            // Even-odd: a hole takes away what the contour around it draws.
            if (found == face.drawn.end()) {
                face.drawn.push_back(structure);
            } else {
                face.drawn.erase(found);
            }
        }
        for (const std::uint32_t structure : face.drawn) {
            if (face.owner == nobody || rank_[structure] < rank_[face.owner]) face.owner = structure;
        }
        return face;
    }
    bool draws(std::uint32_t face, std::uint32_t structure) const {
        const std::vector<std::uint32_t>& drawn = owners_[face].drawn;
        return std::find(drawn.begin(), drawn.end(), structure) != drawn.end();
    }

    const ContourSet& set_;
    const Slice& slice_;
    const std::vector<std::uint32_t>& rank_;
    std::vector<std::uint32_t> structures_;  // per ring
    std::optional<Arrangement> graph_;
    std::vector<Face> owners_;  // per winding
};

std::vector<std::uint32_t> ranks_of(const std::vector<std::uint32_t>& order, std::size_t structures) {
    std::vector<std::uint32_t> rank(structures);
    std::iota(rank.begin(), rank.end(), static_cast<std::uint32_t>(order.size()));
    for (std::uint32_t r = 0; r < order.size(); ++r) rank[order[r]] = r;
    return rank;
}

// Whether some structure has half of its area in another one, or half of that one's. `in_owner`: the area of
// each, then of those that own it.
bool is_nested(std::size_t count, std::span<const double> in_owner) {
    std::vector<double> area(count, 0);
    for (std::size_t n = 0; n < in_owner.size(); ++n) area[n / count] += in_owner[n];
    for (std::size_t n = 0; n < in_owner.size(); ++n) {
        const std::size_t s = n / count, owner = n % count;
        if (s != owner && in_owner[n] > least_given_mm2 &&
            in_owner[n] >= nested_share * std::min(area[s], area[owner]))
            return true;
    }
    return false;
}

}  // namespace

Result<PriorityResult> give_overlaps(const ContourSet& set, const std::vector<std::uint32_t>& order,
                                     RunContext& context) {
    const std::vector<std::uint32_t> rank = ranks_of(order, set.structures.size());
    PriorityResult result;
    result.given.resize(set.structures.size());
    RawContours raw;
    raw.structures = set.structures;
    raw.frame = set.frame;
    raw.pixel_mm = set.pixel_mm;
    raw.source = set.source;
    const std::size_t count = set.structures.size();
    std::vector<double> owned_by(count),
        in_owner(count * count, 0);  // on all slices; by structure, then owner
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        raw.planes.push_back(set.slices[k].plane);
        raw.plane_names.push_back(set.slices[k].name);
        if (set.slices[k].contour_count == 0) continue;
        if (context.cancelled()) return cancelled_error();
        SlicePartition partition(set, set.slices[k], rank);
        if (!partition.arrange_contours()) {
            return Error{ErrorKind::geometry,
                         "E-PRI-001",
                         "the contours of a slice cross too often to be parted",
                         {set.source, set.slices[k].name, "", "", ""},
                         "give no order of the structures"};
        }
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            std::fill(owned_by.begin(), owned_by.end(), 0.0);
            partition.add_region(s, static_cast<std::int32_t>(k), raw, owned_by);
            double given = 0;
            for (std::uint32_t t = 0; t < count; ++t) {
                in_owner[s * count + t] += owned_by[t];
                if (t != s) given += owned_by[t];
            }
            if (given <= least_given_mm2) continue;
            result.given[s].area_mm2 += given;
            ++result.given[s].slices;
        }
    }
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, {}, context));
    result.kept = std::move(cleaned.kept);
    result.kept.exclusive = true;
    result.kept.drawn = set.drawn;
    if (is_nested(count, in_owner)) {
        OverlappingContours overlapping{set, std::vector<std::uint32_t>(rank.size())};
        for (std::uint32_t s = 0; s < rank.size(); ++s) overlapping.order[s] = s;
        std::sort(overlapping.order.begin(), overlapping.order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return rank[a] < rank[b]; });
        result.kept.overlapping = std::make_shared<const OverlappingContours>(std::move(overlapping));
    }
    return result;
}

}  // namespace anatomesh
