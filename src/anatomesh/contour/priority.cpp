#include "anatomesh/contour/priority.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "anatomesh/contour/arrangement.h"
#include "anatomesh/contour/boundary_loops.h"
#include "anatomesh/contour/clean.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

constexpr double sliver_width_mm = 1e-3;
constexpr std::size_t most_edges = 20'000'000;

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

    // Adds what the structure keeps; returns how much of its area it does not.
    double add_region(std::uint32_t structure, std::int32_t plane, RawContours& raw) const {
        std::vector<BoundaryEdge> boundary;
        double drawn = 0, kept = 0;
        for (const Arrangement::Edge& edge : graph_->edges) {
            const Vec2 origin = graph_->at[0];
            const double under = 0.5 * cross(graph_->at[edge.a] - origin, graph_->at[edge.b] - origin);
            const bool left = owners_[edge.left].owner == structure,
                       right = owners_[edge.right].owner == structure;
            if (left != right)
                boundary.push_back(left ? BoundaryEdge{edge.a, edge.b} : BoundaryEdge{edge.b, edge.a});
            kept += under * (left - right);
            drawn += under * (draws(edge.left, structure) - draws(edge.right, structure));
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
        return drawn - kept;
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
    int draws(std::uint32_t face, std::uint32_t structure) const {
        return static_cast<int>(
            std::count(owners_[face].drawn.begin(), owners_[face].drawn.end(), structure));
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
            const double given = partition.add_region(s, static_cast<std::int32_t>(k), raw);
            if (given <= 1e-6) continue;
            result.given[s].area_mm2 += given;
            ++result.given[s].slices;
        }
    }
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, {}, context));
    result.kept = std::move(cleaned.kept);
    result.kept.exclusive = true;
    result.kept.drawn = set.drawn;
    return result;
}

}  // namespace anatomesh
