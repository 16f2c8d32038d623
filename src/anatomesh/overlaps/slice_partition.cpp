#include "anatomesh/overlaps/slice_partition.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/contour/overlay/boundary_loops.h"
#include "anatomesh/geom/polygon.h"

namespace anatomesh {

namespace {

// It stands for a face that no structure has. [index; 2^32 - 1; D]
constexpr std::uint32_t nobody = 0xFFFFFFFFu;

}  // namespace

bool SlicePartition::arrange_contours() {
    std::vector<Ring> rings;
    for (const Contour& contour : set_.contours_of(slice_)) {
        const auto points = set_.points_of(contour);
        rings.push_back(make_ring({points.begin(), points.end()}, slice_.plane,
                                  static_cast<std::uint32_t>(structures_.size())));
        structures_.push_back(contour.structure);
    }
    graph_ = arrange(rings, slice_.plane, most_arrangement_edges);
    if (!graph_) return false;
    for (const Winding& winding : graph_->windings) faces_.push_back(face_of(winding));
    return true;
}

double SlicePartition::add_region(std::uint32_t structure, std::int32_t plane, RawContours& raw) const {
    double drawn = 0, kept = 0;
    std::vector<BoundaryEdge> boundary;
    for (const Arrangement::Edge& edge : graph_->edges) {
        const Vec2 origin = graph_->at[0];
        const double under = 0.5 * cross(graph_->at[edge.a] - origin, graph_->at[edge.b] - origin);
        const bool left = faces_[edge.left].owner == structure, right = faces_[edge.right].owner == structure;
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

void SlicePartition::add_to(Relations& relations) const {
    const auto count = static_cast<std::uint32_t>(rank_.size());
    std::vector<double> area(count, 0), perimeter(count, 0);
    for (const Arrangement::Edge& edge : graph_->edges) {
        const Vec2 origin = graph_->at[0], a = graph_->at[edge.a] - origin, b = graph_->at[edge.b] - origin;
        const double under = 0.5 * cross(a, b);
        for (const auto& [face, sign] : {std::pair{edge.left, 1}, std::pair{edge.right, -1}}) {
            for (const std::uint32_t s : faces_[face].drawn) {
                area[s] += sign * under;
                for (const std::uint32_t t : faces_[face].drawn) relations.of(s, t).common += sign * under;
            }
        }
        std::vector<std::uint32_t> bounded;
        for (std::uint32_t s = 0; s < count; ++s) {
            if (draws(edge.left, s) != draws(edge.right, s)) bounded.push_back(s);
        }
        for (const std::uint32_t s : bounded) {
            perimeter[s] += length(b - a);
            for (const std::uint32_t t : bounded) relations.of(s, t).shared += length(b - a);
        }
    }
    for (std::uint32_t s = 0; s < count; ++s) {
        for (std::uint32_t t = 0; t < count; ++t) {
            if (!(perimeter[s] > 0 && perimeter[t] > 0)) continue;
            relations.of(s, t).area += area[s];
            relations.of(s, t).perimeter += perimeter[s];
        }
    }
}

SlicePartition::Face SlicePartition::face_of(const Winding& winding) const {
    Face face{nobody, {}};
    for (const RingTurns& turns : winding) {
        if (turns.turns % 2 == 0) continue;
        const std::uint32_t structure = structures_[turns.ring];
        const auto found = std::find(face.drawn.begin(), face.drawn.end(), structure);
        // By the even-odd rule a hole takes away what the contour around it draws.
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

bool SlicePartition::draws(std::uint32_t face, std::uint32_t structure) const {
    const std::vector<std::uint32_t>& drawn = faces_[face].drawn;
    return std::find(drawn.begin(), drawn.end(), structure) != drawn.end();
}

}  // namespace anatomesh
