#include "anatomesh/improve/reroute/reroute_attempt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

constexpr int turns = 3;   // of drawing a way near, shapes being improved in between [passes; > 0; B]
constexpr int passes = 4;  // over the vertices of a way, towards what is drawn [passes; > 0; B]
// Shares of the way towards what is drawn, in turn.
// [1; 0 to 1; M 2026-11 282 random sets of planes that cross or lean]
constexpr std::array steps{1.0, 0.5, 0.25};

VertexPair pair_of(std::uint32_t a, std::uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
}

}  // namespace

bool RerouteAttempt::move_near(const SectionPath& path, double near) {
    const std::size_t before = moved_.size();
    for (const auto& [node, place] : path.points) {
        if (node.is_vertex()) continue;
        const double from_p = length(place - edit_.mesh.point(node.p)),
                     from_q = length(place - edit_.mesh.point(node.q));
        const std::uint32_t v = from_p < from_q ? node.p : node.q;
        if (edit_.constraints.fixed(v) || std::min(from_p, from_q) > near * (from_p + from_q)) continue;
        edit_.mesh.star(v, edit_.star);
        if (!edit_.commit_move(v, place)) continue;
        changed_.insert(changed_.end(), edit_.star.begin(), edit_.star.end());
        edit_.constraints.fix(v);
        moved_.push_back(v);
    }
    return moved_.size() > before;
}

bool RerouteAttempt::make_edges(const SectionPath& path, std::uint32_t structure) {
    for (const auto& [node, place] : path.points) {
        if (node.is_vertex()) {
            vertices_.push_back(node.p);
            if (edit_.constraints.fixed(node.p)) continue;
            edit_.constraints.fix(node.p);
            moved_.push_back(node.p);
            continue;
        }
        if (!incidence_.find_ring(node.p, node.q)) return false;
        const bool is_on_contour = edit_.constraints.fixed_edge(node.p, node.q);
        const std::uint32_t v = edit_.split_ring(place);
        if (v == no_cell) return false;
        edit_.constraints.fix(v);
        if (!is_on_contour) moved_.push_back(v);
        changed_.insert(changed_.end(), edit_.changed.begin(), edit_.changed.end());
        vertices_.push_back(v);
    }
    for (std::size_t n = 1; n < vertices_.size(); ++n) {
        if (!incidence_.on_surface(vertices_[n - 1], vertices_[n], structure)) return false;
        edit_.constraints.fix_edge(vertices_[n - 1], vertices_[n]);
        fixed_.push_back({vertices_[n - 1], vertices_[n]});
    }
    return true;
}

bool RerouteAttempt::settle(const ReroutedContour& contour, SectionPath& path) {
    const std::vector<Vec3> drawn = contour.loop.drawn_between(path.from, path.to);
    release(contour, path);
    for (int turn = 0; turn < turns; ++turn) {
        draw_near(drawn);
        for (std::size_t n = 0; n < vertices_.size(); ++n)
            path.points[n].place = edit_.mesh.point(vertices_[n]);
        ContourLoop loop = contour.loop;
        if (turn == 0 && !contours_.replace(contour, {path.from, path.to, vertices_, path.places()}, loop))
            return false;
        improve_cells();
    }
    path.farthest_mm = distance_of_rows(path.places(), drawn);
    return path.farthest_mm <= drawn_.routable.most_mm && is_way_on_surface(contour.contour.structure) &&
           std::all_of(changed_.begin(), changed_.end(), [&](std::uint32_t c) { return is_good(c); });
}

bool RerouteAttempt::is_way_on_surface(std::uint32_t structure) {
    for (std::size_t n = 1; n < vertices_.size(); ++n) {
        if (incidence_.row_from(vertices_[n - 1], vertices_[n], structure).back() != vertices_[n])
            return false;
    }
    return true;
}

// Those of the way that were moved or made, in the plane towards what is drawn.
void RerouteAttempt::draw_near(const std::vector<Vec3>& drawn) {
    std::vector<std::uint32_t> movable = moved_;
    sort_distinct(movable);
    for (int pass = 0; pass < passes; ++pass) {
        bool any = false;
        for (const std::uint32_t v : vertices_) {
            if (std::binary_search(movable.begin(), movable.end(), v) && move_towards(v, drawn)) {
                changed_.insert(changed_.end(), edit_.star.begin(), edit_.star.end());
                any = true;
            }
        }
        if (!any) break;
    }
}

// As far as the shapes of cells allow.
bool RerouteAttempt::move_towards(std::uint32_t v, const std::vector<Vec3>& drawn) {
    const Vec3 from = edit_.mesh.point(v), to = nearest_on_row(drawn, from);
    if (to == from) return false;
    edit_.mesh.star(v, edit_.star);
    const double needed = std::min(worst_in_star(), least_sine_);
    for (const double step : steps) {
        if (!edit_.commit_move(v, from + step * (to - from))) continue;
        if (worst_in_star() >= needed) return true;
        edit_.mesh.move_point(v, from);
    }
    return false;
}

// The least sine of the cells inside.
double RerouteAttempt::worst_in_star() const {
    double worst = 1;
    for (const std::uint32_t c : edit_.star) {
        if (edit_.mesh.region(c) != 0) worst = std::min(worst, edit_.sine(c));
    }
    return worst;
}

RerouteAttempt::ReplacedRow RerouteAttempt::replaced_row(const ReroutedContour& contour,
                                                         const SectionPath& path) const {
    ReplacedRow row;
    for (auto n = static_cast<std::int64_t>(std::floor(path.from)); static_cast<double>(n) < path.to; ++n) {
        const std::uint32_t a = contour.loop.drawn(n), b = contour.loop.drawn(n + 1);
        const double whole = length(edit_.mesh.point(b) - edit_.mesh.point(a));
        const auto place = [&, a = a, b = b](std::uint32_t w) {
            return static_cast<double>(n) +
                   (w == b ? 1 : length(edit_.mesh.point(w) - edit_.mesh.point(a)) / whole);
        };
        for (std::uint32_t last = a; last != b;) {
            const std::uint32_t v = end_of_subsegment(last, a, b, contour.contour.structure);
            if (v == no_cell) break;
            if (place(v) > path.from && place(v) < path.to) row.vertices.push_back(v);
            if (place(last) >= path.from && place(v) <= path.to) row.edges.push_back(pair_of(last, v));
            last = v;
        }
    }
    return row;
}

// Subsegments that the way takes the place of need not be edges any more; vertices of theirs alone may move,
// and do not limit others.
void RerouteAttempt::release(const ReroutedContour& contour, const SectionPath& path) {
    const std::uint32_t structure = contour.contour.structure;
    const ReplacedRow row = replaced_row(contour, path);
    for (const VertexPair& edge : row.edges) {
        const auto is_of_another = [&](const std::array<std::uint32_t, 3>& subsegment) {
            return subsegment[2] != structure && pair_of(subsegment[0], subsegment[1]) == edge;
        };
        if (edit_.constraints.keeps_edge(edge[0], edge[1]) &&
            std::none_of(drawn_.subsegments_beside.begin(), drawn_.subsegments_beside.end(), is_of_another))
            let_go_.push_back(edge);
    }
    for (const VertexPair& edge : let_go_) edit_.constraints.release_edge(edge[0], edge[1]);
    std::vector<std::uint32_t> own = row.vertices;
    own.insert(own.end(), vertices_.begin(), vertices_.end());
    sort_distinct(own);
    for (const std::uint32_t v : row.vertices) {
        // Vertices of contours stay, on the surface, whether it passes through them or not; and so do those
        // that another contour was re-routed along.
        if (!contours_.is_drawn(v) && !contours_.is_on_way(v) &&
            std::find(vertices_.begin(), vertices_.end(), v) == vertices_.end() &&
            is_free_without(own, structure, v))
            free(v);
    }
}

// The end of the subsegment that leads on from v along the segment from a to b.
std::uint32_t RerouteAttempt::end_of_subsegment(std::uint32_t v, std::uint32_t a, std::uint32_t b,
                                                std::uint32_t structure) const {
    const Vec3 way = edit_.mesh.point(b) - edit_.mesh.point(a);
    for (const ContourOwners::Subsegment& subsegment : drawn_.owners->subsegments_at(v)) {
        if (subsegment.structure == structure &&
            SurfaceIncidence::onward(edit_.mesh.point(subsegment.other) - edit_.mesh.point(v), way))
            return subsegment.other;
    }
    return no_cell;
}

// Whether all subsegments at v are of this structure, and end there. `own`: rising.
bool RerouteAttempt::is_free_without(const std::vector<std::uint32_t>& own, std::uint32_t structure,
                                     std::uint32_t v) const {
    const auto subsegments = drawn_.owners->subsegments_at(v);
    return edit_.constraints.fixed(v) && !subsegments.empty() &&
           std::all_of(subsegments.begin(), subsegments.end(),
                       [&](const ContourOwners::Subsegment& subsegment) {
                           return subsegment.structure == structure &&
                                  std::binary_search(own.begin(), own.end(), subsegment.other);
                       });
}

void RerouteAttempt::free(std::uint32_t v) {
    edit_.constraints.unfix(v);
    released_.push_back(v);
    limits_before_.push_back(
        v < constraint_limited_.size() ? std::exchange(constraint_limited_[v], std::uint8_t{0}) : 0);
    edit_.mesh.star(v, edit_.star);
    changed_.insert(changed_.end(), edit_.star.begin(), edit_.star.end());
}

void RerouteAttempt::improve_cells() {
    sort_distinct(changed_);
    const std::vector<std::uint32_t> improved = improve_(changed_);
    changed_.insert(changed_.end(), improved.begin(), improved.end());
    sort_distinct(changed_);
}

bool RerouteAttempt::is_good(std::uint32_t c) const {
    if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return true;
    const Cell& v = edit_.mesh.cell(c);
    const bool forced = drawn_.are_constraint_limited(v) || shortest_is_drawn(v);
    const CellMeasures m = measure_cell(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]),
                                        edit_.mesh.point(v[2]), edit_.mesh.point(v[3]));
    const double most = forced ? most_limited_ratio : edit_.options.last_radius_edge;
    return m.least_sine() >= (forced ? least_limited_sine : least_sine_) && m.squared_ratio <= most * most;
}

// Whether the shortest edge of a cell joins two vertices of contours as they are drawn.
bool RerouteAttempt::shortest_is_drawn(const Cell& v) const {
    double shortest = HUGE_VAL;
    bool is_drawn = false;
    for (const auto& [i, j] : cell_edges) {
        const double edge = squared_length(edit_.mesh.point(v[i]) - edit_.mesh.point(v[j]));
        if (edge >= shortest) continue;
        shortest = edge;
        is_drawn = contours_.is_drawn(v[i]) && contours_.is_drawn(v[j]);
    }
    return is_drawn;
}

void RerouteAttempt::take_back() {
    for (const std::uint32_t v : moved_) edit_.constraints.unfix(v);
    for (std::size_t n = 0; n < released_.size(); ++n) {
        edit_.constraints.fix(released_[n]);
        if (released_[n] < constraint_limited_.size()) constraint_limited_[released_[n]] = limits_before_[n];
    }
    for (const VertexPair& edge : let_go_) edit_.constraints.keep_edge(edge[0], edge[1]);
    for (const VertexPair& edge : fixed_) edit_.constraints.unfix_edge(edge[0], edge[1]);
}

void RerouteAttempt::keep(const Contour& contour) {
    contours_.note_way(contour, vertices_);
    for (const std::uint32_t v : moved_) {
        if (std::find(vertices_.begin(), vertices_.end(), v) == vertices_.end()) edit_.constraints.unfix(v);
    }
}

}  // namespace anatomesh
