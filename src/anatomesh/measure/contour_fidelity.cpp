#include "anatomesh/measure/contour_fidelity.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/mesh/model/surface_graph.h"

namespace anatomesh {

namespace {

// A contour that turns at a smaller angle forces cells. [degrees; 0 to 180; C clause 4]
constexpr double small_angle_deg = 60.0;
// Contours that share a vertex and meet at a smaller angle force cells. [degrees; 0 to 90; C clause 4]
constexpr double small_crossing_deg = 30.0;

// The vertices of a surface in lexicographic order.
class VerticesByPlace {
  public:
    VerticesByPlace(std::span<const Vec3> points, const std::vector<Triangle>& triangles) : points_(points) {
        for (const Triangle& f : triangles) by_place_.insert(by_place_.end(), f.begin(), f.end());
        sort_distinct(by_place_, points.size());
        std::sort(by_place_.begin(), by_place_.end(), [&](std::uint32_t a, std::uint32_t b) {
            if (points[a] == points[b]) return a < b;
            return lexicographic_less(points[a], points[b]);
        });
    }

    // The vertex with exactly these coordinates, or no_cell.
    std::uint32_t find(Vec3 p) const {
        const auto at = std::lower_bound(by_place_.begin(), by_place_.end(), p, [&](std::uint32_t v, Vec3 q) {
            return lexicographic_less(points_[v], q);
        });
        return at != by_place_.end() && points_[*at] == p ? *at : no_cell;
    }

  private:
    std::span<const Vec3> points_;
    std::vector<std::uint32_t> by_place_;
};

}  // namespace

ContourFidelity contour_fidelity(std::span<const Vec3> points,
                                 std::span<const std::vector<Triangle>> surfaces,
                                 const ContourSet& contours) {
    assert(surfaces.size() == contours.structures.size());
    ContourFidelity fidelity;
    fidelity.structures.resize(contours.structures.size());
    fidelity.vertex_of.assign(contours.points.size(), no_cell);
    fidelity.segments_missed.assign(contours.contours.size(), 0);
    // One structure's graph at a time: there may be hundreds of structures.
    std::vector<std::uint32_t> order(contours.contours.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return contours.contours[a].structure < contours.contours[b].structure;
    });
    for (std::size_t i = 0; i < order.size();) {
        const std::uint32_t structure = contours.contours[order[i]].structure;
        const SurfaceGraph graph(points, surfaces[structure]);
        const VerticesByPlace places(points, surfaces[structure]);
        StructureFidelity& count = fidelity.structures[structure];
        for (; i < order.size() && contours.contours[order[i]].structure == structure; ++i) {
            const Contour& contour = contours.contours[order[i]];
            std::uint32_t* const vertex = fidelity.vertex_of.data() + contour.first_point;
            for (std::uint32_t p = 0; p < contour.point_count; ++p) {
                vertex[p] = places.find(contours.points[contour.first_point + p]);
                ++count.vertices;
                count.vertices_on_surface += vertex[p] != no_cell;
            }
            for (std::uint32_t p = 0; p < contour.point_count; ++p) {
                const std::uint32_t a = vertex[p], b = vertex[(p + 1) % contour.point_count];
                ++count.segments;
                const bool found = a != no_cell && b != no_cell && graph.chain(a, b);
                count.segments_on_surface += found;
                fidelity.segments_missed[order[i]] += !found;
                if (!found) fidelity.missed.push_back({order[i], p});
            }
        }
    }
    return fidelity;
}

ForcedCells::ForcedCells(const TetMesh& mesh, const ContourSet& contours,
                         std::span<const std::uint32_t> vertex_of)
    : mesh_(mesh),
      contours_(contours),
      point_at_(mesh.points.size(), no_cell),
      contour_of_(contours.points.size()) {
    for (std::uint32_t c = 0; c < contours.contours.size(); ++c) {
        const Contour& contour = contours.contours[c];
        for (std::uint32_t p = 0; p < contour.point_count; ++p) contour_of_[contour.first_point + p] = c;
    }
    for (std::uint32_t p = 0; p < vertex_of.size(); ++p) {
        const std::uint32_t v = vertex_of[p];
        if (v != no_cell && point_at_[v] == no_cell) point_at_[v] = p;
    }
}

std::string ForcedCells::slice_name(std::uint32_t point) const {
    const std::uint32_t slice = contours_.contours[contour_of_[point]].slice;
    const std::string& name = contours_.slices[slice].name;
    return name.empty() ? std::to_string(slice) : name;
}

double ForcedCells::contour_angle(std::uint32_t point) const {
    const Contour& contour = contours_.contours[contour_of_[point]];
    const std::uint32_t at = point - contour.first_point, n = contour.point_count;
    const Vec3 here = contours_.points[point];
    const Vec3 to = contours_.points[contour.first_point + (at + 1) % n] - here;
    const Vec3 from = contours_.points[contour.first_point + (at + n - 1) % n] - here;
    return std::atan2(length(cross(to, from)), dot(to, from)) * 180.0 / std::numbers::pi;
}

ForcedCells::ShortestEdge ForcedCells::shortest_edge(std::uint32_t cell) const {
    const Cell& vertices = mesh_.cells[cell];
    ShortestEdge shortest{no_cell, no_cell, -1};
    for (const auto& [i, j] : cell_edges) {
        const std::uint32_t v = vertices[static_cast<std::size_t>(i)],
                            w = vertices[static_cast<std::size_t>(j)];
        const double edge = length(mesh_.points[w] - mesh_.points[v]);
        if (shortest.length < 0 || edge < shortest.length) shortest = {point_at_[v], point_at_[w], edge};
    }
    return shortest;
}

std::uint32_t ForcedCells::sharp_vertex(std::uint32_t cell) const {
    for (const std::uint32_t v : mesh_.cells[cell]) {
        if (point_at_[v] != no_cell && contour_angle(point_at_[v]) < small_angle_deg) return point_at_[v];
    }
    return no_cell;
}

bool ForcedCells::forced(std::uint32_t cell) const {
    const ShortestEdge shortest = shortest_edge(cell);
    return (shortest.a != no_cell && shortest.b != no_cell) || sharp_vertex(cell) != no_cell;
}

bool ForcedCells::limits(std::uint32_t vertex) const {
    return constraint_limited_.contains(vertex) ||
           (point_at_[vertex] != no_cell && contour_angle(point_at_[vertex]) < small_angle_deg);
}

std::string ForcedCells::limit_reason(std::uint32_t cell) const {
    for (const std::uint32_t v : mesh_.cells[cell]) {
        const auto constraint_limited = constraint_limited_.find(v);
        if (constraint_limited == constraint_limited_.end()) continue;
        const ConstraintLimit& found = constraint_limited->second;
        const std::string other =
            "at vertex " + std::to_string(found.segment) + " in slice " + slice_name(found.segment);
        if (found.angle_deg < 180) {
            return "an angle of " + fixed_text(found.angle_deg, 1) +
                   " degrees between the contours at vertex " + std::to_string(found.own) + " in slice " +
                   slice_name(found.own) + " and " + other;
        }
        return (point_at_[v] != no_cell ? "contour vertex " : "the contour from vertex ") +
               std::to_string(found.own) + " in slice " + slice_name(found.own) + " " +
               fixed_text(found.distance, 4) + " mm from the contour " + other;
    }
    return {};
}

Vec3 ForcedCells::segment_end(std::uint32_t from) const {
    const Contour& contour = contours_.contours[contour_of_[from]];
    return contours_.points[contour.first_point + (from - contour.first_point + 1) % contour.point_count];
}

void ForcedCells::find_constraint_limited(std::span<const std::uint32_t> cells, double distance_mm) {
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t cell : cells)
        vertices.insert(vertices.end(), mesh_.cells[cell].begin(), mesh_.cells[cell].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    find_constraint_limited_at(vertices, distance_mm);
}

void ForcedCells::find_constraint_limited_at(const std::vector<std::uint32_t>& vertices, double distance_mm) {
    if (vertices.empty() || !(distance_mm > 0)) return;
    const double piece_mm = 4 * distance_mm;
    PointGrid grid(piece_mm, vertices.size());
    for (const std::uint32_t v : vertices) grid.add(mesh_.points[v]);
    std::vector<std::vector<NearSegment>> near(vertices.size());
    for (const Contour& contour : contours_.contours) {
        for (std::uint32_t n = 0; n < contour.point_count; ++n) {
            const std::uint32_t from = contour.first_point + n;
            const Vec3 a = contours_.points[from], b = segment_end(from);
            const double span = length(b - a);
            if (!(span > 0)) continue;
            const double pieces = std::max(1.0, std::ceil(span / piece_mm));
            const auto look_at = [&](std::uint32_t i, double) {
                const Vec3 p = mesh_.points[vertices[i]];
                const double along = std::clamp(dot(p - a, b - a) / (span * span), 0.0, 1.0);
                const double distance = length(p - (a + along * (b - a)));
                if (distance > distance_mm || (!near[i].empty() && near[i].back().from == from)) return;
                near[i].push_back({from, a, b, distance});
            };
            for (double piece = 0.5; piece < pieces; ++piece) {
                grid.for_each_within(a + piece / pieces * (b - a), 0.5 * span / pieces + distance_mm,
                                     look_at);
            }
        }
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const std::uint32_t v = vertices[i];
        const ConstraintLimit found = point_at_[v] != no_cell
                                          ? limit_of_vertex(point_at_[v], near[i], distance_mm)
                                          : limit_of_segment(near[i]);
        if (found.segment != no_cell) constraint_limited_[v] = found;
    }
}

// Other segments near a contour vertex, or two there that make a small angle.
ForcedCells::ConstraintLimit ForcedCells::limit_of_vertex(std::uint32_t point,
                                                          const std::vector<NearSegment>& near,
                                                          double distance_mm) const {
    const Vec3 p = contours_.points[point];
    ConstraintLimit constraint_limited;
    for (const NearSegment& s : near) {
        // Its own place, also where several contours share it, does not limit it.
        const double distance = p == s.a || p == s.b ? length(s.b - s.a) : s.distance;
        if (distance <= distance_mm &&
            (constraint_limited.segment == no_cell || distance < constraint_limited.distance))
            constraint_limited = {point, s.from, distance};
    }
    if (constraint_limited.segment != no_cell) return constraint_limited;
    for (const NearSegment& s : near) {
        for (const NearSegment& t : near) {
            const double angle = angle_between(s, t, p);
            if (angle > 0 && angle < small_crossing_deg && angle < constraint_limited.angle_deg)
                constraint_limited = {s.from, t.from, 0, angle};
        }
    }
    return constraint_limited;
}

// Other segments near a vertex within one, but for those that go on from it without turning back.
ForcedCells::ConstraintLimit ForcedCells::limit_of_segment(const std::vector<NearSegment>& near) const {
    std::vector<NearSegment> own;
    for (const NearSegment& s : near) {
        if (s.distance <= on_segment_share * length(s.b - s.a)) own.push_back(s);
    }
    ConstraintLimit constraint_limited;
    for (const NearSegment& s : near) {
        const bool goes_on = std::any_of(own.begin(), own.end(), [&](const NearSegment& o) {
            return o.from == s.from ||
                   std::max(angle_between(o, s, o.a), angle_between(o, s, o.b)) >= small_angle_deg ||
                   s.distance <= on_segment_share * length(s.b - s.a);
        });
        if (own.empty() || goes_on) continue;
        if (constraint_limited.segment == no_cell || s.distance < constraint_limited.distance)
            constraint_limited = {own.front().from, s.from, s.distance};
    }
    return constraint_limited;
}

// At p, in degrees; 0 where they do not both end there.
double ForcedCells::angle_between(const NearSegment& s, const NearSegment& t, Vec3 p) {
    if ((p != s.a && p != s.b) || (p != t.a && p != t.b)) return 0;
    const Vec3 u = (p == s.a ? s.b : s.a) - p, w = (p == t.a ? t.b : t.a) - p;
    return std::atan2(length(cross(u, w)), dot(u, w)) * 180.0 / std::numbers::pi;
}

std::string ForcedCells::reason(std::uint32_t cell) const {
    const ShortestEdge shortest = shortest_edge(cell);
    if (shortest.a != no_cell && shortest.b != no_cell) {
        const std::uint32_t a = std::min(shortest.a, shortest.b), b = std::max(shortest.a, shortest.b);
        const std::string one = slice_name(a), two = slice_name(b);
        return "contour vertices " + std::to_string(a) + " and " + std::to_string(b) + " " +
               fixed_text(shortest.length, 3) + " mm apart in " +
               (one == two ? "slice " + one : "slices " + one + " and " + two);
    }
    const std::uint32_t sharp = sharp_vertex(cell);
    if (sharp == no_cell) return limit_reason(cell);
    return "an angle of " + fixed_text(contour_angle(sharp), 1) + " degrees at contour vertex " +
           std::to_string(sharp) + " in slice " + slice_name(sharp);
}

std::vector<std::uint8_t> constraint_limited_vertices(const TetMesh& mesh, const ContourSet& contours,
                                                      std::span<const std::uint32_t> vertex_of,
                                                      const std::vector<std::uint32_t>& vertices,
                                                      double share) {
    std::size_t inside = 0;
    double edges = 0;
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
        if (mesh.regions[c] == 0) continue;
        ++inside;
        const Cell& v = mesh.cells[c];
        edges += 0.5 * (length(mesh.points[v[1]] - mesh.points[v[0]]) +
                        length(mesh.points[v[3]] - mesh.points[v[2]]));
    }
    ForcedCells forced(mesh, contours, vertex_of);
    if (inside > 0) forced.find_constraint_limited_at(vertices, share * edges / static_cast<double>(inside));
    std::vector<std::uint8_t> constraint_limited(mesh.points.size(), 0);
    for (const std::uint32_t v : vertices) constraint_limited[v] = forced.limits(v);
    return constraint_limited;
}

}  // namespace anatomesh
