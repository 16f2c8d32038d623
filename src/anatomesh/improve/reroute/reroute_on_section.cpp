#include "anatomesh/improve/reroute/reroute_on_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/reroute/contour_loop.h"
#include "anatomesh/improve/reroute/surface_section.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

constexpr double on_segment = 1e-6;  // a vertex within it lies on a segment, in its lengths, or in its plane
constexpr std::size_t most_missed = 1000;   // segments: where more are, the cells do not fit the contours
constexpr std::size_t most_attempts = 400;  // to lead one
constexpr int contour_rounds = 3;           // over the contours: one may need that beside it
constexpr std::size_t last_missed = 10;     // segments: no more than these may ask for worse shapes
constexpr std::size_t most_beside = 6;      // segments on either side of a missed one that a way may replace
constexpr double reach = 2;                 // and how far along them it may end, in most_mm
constexpr int turns = 3;                    // of drawing a way near, shapes being improved in between
constexpr int passes = 4;                   // over the vertices of a way, towards what is drawn
// Of an edge that a way crosses: a free end as near as that moves onto the way. Tried in turn.
constexpr std::array nearness{0.3, 0.5, 0.1};
constexpr std::array steps{1.0, 0.5, 0.25};  // towards what is drawn

// A contour, and what came of it.
struct ReroutedContour {
    std::uint32_t number = 0;
    Contour contour;
    ContourLoop loop;
    bool is_rerouted = false;
    std::uint64_t segments = 0;
    double farthest_mm = 0;
};

// When a segment was tried in vain last.
struct Tried {
    std::vector<std::uint32_t> reach = {};  // vertices where a way might have ended; rising
    std::size_t changed_before = 0;         // cells, before it
};

// Where a way may leave the contour, or come back to it: from a missed segment outwards.
struct Shore {
    std::vector<LoopCorner> corners;
    std::vector<WayEnd> ends;  // at the price of what lies between them and the segment
    double length = 0;

    double at(std::uint32_t vertex) const {
        return std::find_if(corners.begin(), corners.end(),
                            [&](const LoopCorner& corner) { return corner.vertex == vertex; })
            ->at;
    }
};

// Over the section of the surface, and the places between which it replaces what is drawn.
struct SectionPath {
    std::vector<SectionPoint> points;
    double from = 0, to = 0;
    double farthest_mm = 0;

    std::vector<Vec3> places() const {
        std::vector<Vec3> all;
        for (const SectionPoint& point : points) all.push_back(point.place);
        return all;
    }
};

// What an attempt has done to the edit context beside the mesh.
struct Attempt {
    std::vector<std::uint32_t> changed;            // cells
    std::vector<std::uint32_t> moved;              // vertices that were free, or new ones on no other contour
    std::vector<std::uint32_t> released;           // vertices that were fixed
    std::vector<std::uint8_t> constraint_limited;  // what these were
    std::vector<VertexPair> let_go;                // edges that were kept
    std::vector<VertexPair> fixed;                 // edges
};

class SectionRerouting {
  public:
    SectionRerouting(EditContext& edit, const DrawnSlices& drawn, std::span<std::uint8_t> constraint_limited,
                     double least_sine, double last_sine, const ImproveCells& improve,
                     const RunContext& context)
        : edit_(edit),
          drawn_(drawn),
          constraint_limited_(constraint_limited),
          routable_(drawn.routable),
          incidence_(edit),
          least_sine_(least_sine),
          last_sine_(last_sine),
          improve_(improve),
          context_(context) {}

    RerouteStats run() {
        RerouteStats stats;
        for (std::uint32_t n = 0; n < routable_.contours.size(); ++n) {
            ReroutedContour rerouted = as_drawn(n);
            const std::size_t missed = count_missed(rerouted);
            stats.missed += missed;
            if (missed > 0) contours_.push_back(std::move(rerouted));
        }
        if (contours_.empty() || stats.missed > most_missed) return stats;
        find_vertices();
        lead_all();
        std::size_t left = 0;
        for (const ReroutedContour& rerouted : contours_) left += count_missed(rerouted);
        if (left > 0 && left <= last_missed) {
            least_sine_ = std::min(least_sine_, last_sine_);
            tried_.clear();
            attempts_ = 0;
            lead_all();
        }
        for (const ReroutedContour& rerouted : contours_) {
            if (!rerouted.is_rerouted || is_as_drawn(rerouted)) continue;
            RoutedContour& routed = stats.routed.emplace_back(
                RoutedContour{rerouted.number, {}, rerouted.segments, rerouted.farthest_mm});
            for (std::size_t n = 0; n < rerouted.loop.size(); ++n)
                routed.vertices.push_back(rerouted.loop.corner(n).vertex);
        }
        stats.changed = std::move(changed_);
        return stats;
    }

  private:
    void lead_all() {
        for (int round = 0; round < contour_rounds; ++round) {
            bool any = false;
            for (ReroutedContour& rerouted : contours_) any |= route(rerouted);
            if (!any) break;
        }
    }

    ReroutedContour as_drawn(std::uint32_t number) const {
        const Contour& contour = routable_.contours[number];
        const auto vertices = routable_.vertices.subspan(contour.first_point, contour.point_count);
        std::vector<Vec3> places;
        for (const std::uint32_t v : vertices) places.push_back(edit_.mesh.point(v));
        return {number, contour, {vertices, std::move(places)}};
    }

    // Whether all of it is edges of the surface where it is drawn: a way may lie on that.
    bool is_as_drawn(const ReroutedContour& rerouted) {
        const ReroutedContour drawn = as_drawn(rerouted.number);
        return count_missed(drawn) == 0;
    }

    bool is_missed(const ReroutedContour& rerouted, std::size_t n) {
        const std::uint32_t a = rerouted.loop.corner(n).vertex, b = rerouted.loop.corner(n + 1).vertex;
        return incidence_.row_from(a, b, rerouted.contour.structure).back() != b;
    }

    std::size_t count_missed(const ReroutedContour& rerouted) {
        std::size_t missed = 0;
        for (std::size_t n = 0; n < rerouted.loop.size(); ++n) missed += is_missed(rerouted, n);
        return missed;
    }

    static std::uint64_t drawing(const Contour& contour) {
        return static_cast<std::uint64_t>(contour.slice) << 32 | contour.structure;
    }

    void find_vertices() {
        for (const Contour& contour : routable_.contours) {
            for (std::uint32_t n = 0; n < contour.point_count; ++n)
                note(contour, routable_.vertices[contour.first_point + n]);
        }
        for (auto& [key, vertices] : of_drawing_) sort_distinct(vertices);
        for (auto& [slice, vertices] : of_slice_) sort_distinct(vertices);
        drawn_vertices_.assign(routable_.vertices.begin(), routable_.vertices.end());
        sort_distinct(drawn_vertices_);
    }

    void note(const Contour& contour, std::uint32_t v) {
        of_drawing_[drawing(contour)].push_back(v);
        of_slice_[contour.slice].push_back(v);
    }

    // Whether any of it was re-routed.
    bool route(ReroutedContour& rerouted) {
        bool any = false;
        for (std::size_t n = 0; n < rerouted.loop.size() && attempts_ < most_attempts; ++n) {
            if (context_.cancelled() || !is_missed(rerouted, n)) continue;
            const std::size_t before = count_missed(rerouted);
            const Shore here = shore(rerouted, n, -1), there = shore(rerouted, n, 1);
            if (is_known_to_fail(rerouted, n, here, there)) continue;
            if (std::none_of(nearness.begin(), nearness.end(), [&](double near) {
                    ++attempts_;
                    return attempt(rerouted, here, there, near);
                }))
                continue;
            rerouted.segments += before - std::min(before, count_missed(rerouted));
            rerouted.is_rerouted = any = true;
        }
        return any;
    }

    // Whether the segment was tried when no cell at its surroundings was another one; notes that it is tried.
    bool is_known_to_fail(const ReroutedContour& rerouted, std::size_t n, const Shore& here,
                          const Shore& there) {
        Tried& tried =
            tried_[{rerouted.loop.corner(n).vertex, rerouted.loop.corner(n + 1).vertex, rerouted.number}];
        const bool fails =
            !tried.reach.empty() &&
            std::none_of(changed_.begin() + static_cast<std::ptrdiff_t>(tried.changed_before), changed_.end(),
                         [&](std::uint32_t c) {
                             const Cell& cell = edit_.mesh.cell(c);
                             return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                                 return std::binary_search(tried.reach.begin(), tried.reach.end(), v);
                             });
                         });
        tried.changed_before = changed_.size();
        tried.reach.clear();
        for (const Shore* const shore : {&here, &there}) {
            for (const WayEnd& end : shore->ends) tried.reach.push_back(end.vertex);
        }
        sort_distinct(tried.reach);
        return fails;
    }

    // Vertices of the contour that edges of its surface join to others, from missed segment n on: `step` is
    // +1 for those after it, -1 for those before it.
    Shore shore(const ReroutedContour& rerouted, std::size_t n, int step) {
        const std::size_t count = rerouted.loop.size(), most = std::min(most_beside, (count - 2) / 2);
        Shore found;
        // From the segment's other end on.
        LoopCorner x = rerouted.loop.corner(n);
        if (step < 0) x = rerouted.loop.beside(n, x.at, 1);
        for (std::size_t k = 0; k <= most && found.length <= reach * routable_.most_mm; ++k) {
            const LoopCorner y = rerouted.loop.beside(step > 0 ? n + k : n + 1 + count - k, x.at, step);
            add_row(rerouted.contour.structure, x, y, k > 0, found);
            x = y;
        }
        return found;
    }

    // Of the segment from x to y without x: all, or what there is of it on y's side - and on x's, if asked
    // for - of where it is missed.
    void add_row(std::uint32_t structure, const LoopCorner& x, const LoopCorner& y, bool both, Shore& shore) {
        std::vector<std::uint32_t> row = incidence_.row_from(y.vertex, x.vertex, structure);
        if (both && row.back() != x.vertex) {
            for (const std::uint32_t v : incidence_.row_from(x.vertex, y.vertex, structure))
                add(x, y, v, shore);
        }
        std::reverse(row.begin(), row.end());
        for (const std::uint32_t v : row) add(x, y, v, shore);
    }

    void add(const LoopCorner& x, const LoopCorner& y, std::uint32_t v, Shore& shore) const {
        if (v == x.vertex) return;
        const Vec3 p = edit_.mesh.point(v);
        if (!shore.corners.empty()) shore.length += length(p - edit_.mesh.point(shore.corners.back().vertex));
        const Vec3 a = edit_.mesh.point(x.vertex), b = edit_.mesh.point(y.vertex);
        shore.corners.push_back({v, x.at + length(p - a) / length(b - a) * (y.at - x.at)});
        if (v == y.vertex) shore.corners.back() = y;
        shore.ends.push_back({v, shore.length});
    }

    std::optional<SectionPath> find_way(const ReroutedContour& rerouted, const Shore& here,
                                        const Shore& there) {
        const Contour& contour = rerouted.contour;
        const std::vector<Vec3> drawn =
            rerouted.loop.drawn_between(here.corners.back().at, there.corners.back().at);
        double longest = 0;
        for (std::size_t n = 1; n < drawn.size(); ++n)
            longest = std::max(longest, length(drawn[n] - drawn[n - 1]));
        SurfaceSection section(edit_, routable_.planes[contour.slice], contour.structure,
                               on_segment * longest, of_slice_[contour.slice]);
        const std::vector<std::uint32_t>& taken = of_drawing_[drawing(contour)];
        const auto is_end = [&](std::uint32_t v) {
            return std::any_of(there.ends.begin(), there.ends.end(),
                               [&](const WayEnd& end) { return end.vertex == v; });
        };
        std::optional<std::vector<SectionPoint>> points =
            section.shortest_way(here.ends, there.ends, [&](const SectionPoint& point) {
                if (point.node.is_vertex() && !is_end(point.node.p) &&
                    std::binary_search(taken.begin(), taken.end(), point.node.p))
                    return false;
                return length(point.place - nearest_on_row(drawn, point.place)) <= routable_.most_mm;
            });
        if (!points) return std::nullopt;
        SectionPath way{std::move(*points)};
        way.from = here.at(way.points.front().node.p);
        way.to = there.at(way.points.back().node.p);
        way.farthest_mm = distance_of_rows(way.places(), rerouted.loop.drawn_between(way.from, way.to));
        return way;
    }

    bool attempt(ReroutedContour& rerouted, const Shore& here, const Shore& there, double near) {
        std::optional<SectionPath> way = find_way(rerouted, here, there);
        if (!way) return false;
        const MeshImprovementStats stats = edit_.stats;
        edit_.mesh.begin_attempt();
        Attempt done;
        while (way && move_near(*way, near, done)) way = find_way(rerouted, here, there);
        ContourLoop loop = rerouted.loop;
        std::vector<std::uint32_t> vertices;
        const bool good = way && make_edges(*way, rerouted.contour.structure, vertices, done) &&
                          settle(rerouted, *way, vertices, done) && replace(rerouted, *way, vertices, loop);
        edit_.mesh.end_attempt(good);
        if (!good) {
            take_back(done);
            edit_.stats = stats;
            return false;
        }
        rerouted.loop = std::move(loop);
        rerouted.farthest_mm = std::max(rerouted.farthest_mm, way->farthest_mm);
        keep(rerouted.contour, vertices, done);
        return true;
    }

    // Draws the way, now edges, near to what is drawn, and improves the shapes. False if the cells are bad
    // then, or if it went too far.
    bool settle(const ReroutedContour& rerouted, SectionPath& way, const std::vector<std::uint32_t>& vertices,
                Attempt& done) {
        const std::vector<Vec3> drawn = rerouted.loop.drawn_between(way.from, way.to);
        release(rerouted, way, vertices, done);
        for (int turn = 0; turn < turns; ++turn) {
            draw_near(drawn, vertices, done);
            for (std::size_t n = 0; n < vertices.size(); ++n)
                way.points[n].place = edit_.mesh.point(vertices[n]);
            ContourLoop loop = rerouted.loop;
            if (turn == 0 && !replace(rerouted, way, vertices, loop)) return false;
            improve_cells(done);
        }
        way.farthest_mm = distance_of_rows(way.places(), drawn);
        return way.farthest_mm <= routable_.most_mm && is_on_surface(vertices, rerouted.contour.structure) &&
               std::all_of(done.changed.begin(), done.changed.end(),
                           [&](std::uint32_t c) { return is_good(c); });
    }

    // Puts the way into the loop; false if the slice's contours are none of a kept set then.
    bool replace(const ReroutedContour& rerouted, const SectionPath& way,
                 const std::vector<std::uint32_t>& vertices, ContourLoop& loop) const {
        return loop.replace({way.from, way.to, vertices, way.places()}) && is_sound(rerouted, loop);
    }

    bool is_on_surface(const std::vector<std::uint32_t>& way, std::uint32_t structure) {
        for (std::size_t n = 1; n < way.size(); ++n) {
            if (incidence_.row_from(way[n - 1], way[n], structure).back() != way[n]) return false;
        }
        return true;
    }

    // Free ends of edges that the way crosses near them, onto it; says whether there were any.
    bool move_near(const SectionPath& way, double near, Attempt& done) {
        const std::size_t before = done.moved.size();
        for (const auto& [node, place] : way.points) {
            if (node.is_vertex()) continue;
            const double from_p = length(place - edit_.mesh.point(node.p)),
                         from_q = length(place - edit_.mesh.point(node.q));
            const std::uint32_t v = from_p < from_q ? node.p : node.q;
            if (edit_.constraints.fixed(v) || std::min(from_p, from_q) > near * (from_p + from_q)) continue;
            edit_.mesh.star(v, edit_.star);
            if (!edit_.commit_move(v, place)) continue;
            done.changed.insert(done.changed.end(), edit_.star.begin(), edit_.star.end());
            edit_.constraints.fix(v);
            done.moved.push_back(v);
        }
        return done.moved.size() > before;
    }

    // Puts vertices on the edges that the way crosses; false if it is not edges of the surface then.
    bool make_edges(const SectionPath& way, std::uint32_t structure, std::vector<std::uint32_t>& vertices,
                    Attempt& done) {
        for (const auto& [node, place] : way.points) {
            if (node.is_vertex()) {
                vertices.push_back(node.p);
                if (edit_.constraints.fixed(node.p)) continue;
                edit_.constraints.fix(node.p);
                done.moved.push_back(node.p);
                continue;
            }
            if (!incidence_.find_ring(node.p, node.q)) return false;
            const bool is_on_contour = edit_.constraints.fixed_edge(node.p, node.q);
            const std::uint32_t v = edit_.split_ring(place);
            if (v == no_cell) return false;
            edit_.constraints.fix(v);
            if (!is_on_contour) done.moved.push_back(v);
            done.changed.insert(done.changed.end(), edit_.changed.begin(), edit_.changed.end());
            vertices.push_back(v);
        }
        for (std::size_t n = 1; n < vertices.size(); ++n) {
            if (!incidence_.on_surface(vertices[n - 1], vertices[n], structure)) return false;
            edit_.constraints.fix_edge(vertices[n - 1], vertices[n]);
            done.fixed.push_back({vertices[n - 1], vertices[n]});
        }
        return true;
    }

    // Those of the way that were moved or made, in the plane towards what is drawn.
    void draw_near(const std::vector<Vec3>& drawn, const std::vector<std::uint32_t>& vertices,
                   Attempt& done) {
        std::vector<std::uint32_t> movable = done.moved;
        sort_distinct(movable);
        for (int pass = 0; pass < passes; ++pass) {
            bool any = false;
            for (const std::uint32_t v : vertices) {
                if (std::binary_search(movable.begin(), movable.end(), v) && move_towards(v, drawn)) {
                    done.changed.insert(done.changed.end(), edit_.star.begin(), edit_.star.end());
                    any = true;
                }
            }
            if (!any) break;
        }
    }

    // As far as the shapes of cells allow.
    bool move_towards(std::uint32_t v, const std::vector<Vec3>& drawn) {
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
    double worst_in_star() const {
        double worst = 1;
        for (const std::uint32_t c : edit_.star) {
            if (edit_.mesh.region(c) != 0) worst = std::min(worst, edit_.sine(c));
        }
        return worst;
    }

    // Subsegments of segments that the way takes the place of: their edges need not be there any more,
    // vertices of theirs alone may move, and do not limit others.
    void release(const ReroutedContour& rerouted, const SectionPath& way,
                 const std::vector<std::uint32_t>& vertices, Attempt& done) {
        std::vector<std::uint32_t> row;
        std::vector<VertexPair> edges;
        for (auto n = static_cast<std::int64_t>(std::floor(way.from)); static_cast<double>(n) < way.to; ++n) {
            const std::uint32_t a = rerouted.loop.drawn(n), b = rerouted.loop.drawn(n + 1);
            const double whole = length(edit_.mesh.point(b) - edit_.mesh.point(a));
            for (std::uint32_t last = a; last != b;) {
                const std::uint32_t v = end_of_subsegment(last, a, b, rerouted.contour.structure);
                if (v == no_cell) break;
                const auto place = [&](std::uint32_t w) {
                    return static_cast<double>(n) +
                           (w == b ? 1 : length(edit_.mesh.point(w) - edit_.mesh.point(a)) / whole);
                };
                if (place(v) > way.from && place(v) < way.to) row.push_back(v);
                if (place(last) >= way.from && place(v) <= way.to)
                    edges.push_back({std::min(last, v), std::max(last, v)});
                last = v;
            }
        }
        for (const VertexPair& edge : edges) {
            const auto is_of_another = [&](const std::array<std::uint32_t, 3>& subsegment) {
                return subsegment[2] != rerouted.contour.structure &&
                       VertexPair{std::min(subsegment[0], subsegment[1]),
                                  std::max(subsegment[0], subsegment[1])} == edge;
            };
            if (edit_.constraints.keeps_edge(edge[0], edge[1]) &&
                std::none_of(drawn_.subsegments_beside.begin(), drawn_.subsegments_beside.end(),
                             is_of_another))
                done.let_go.push_back(edge);
        }
        for (const VertexPair& edge : done.let_go) edit_.constraints.release_edge(edge[0], edge[1]);
        std::vector<std::uint32_t> own = row;
        own.insert(own.end(), vertices.begin(), vertices.end());
        sort_distinct(own);
        for (const std::uint32_t v : row) {
            // Vertices of contours stay, on the surface, whether it passes through them or not; and so do
            // those that another contour was re-routed along.
            if (!std::binary_search(drawn_vertices_.begin(), drawn_vertices_.end(), v) &&
                !std::binary_search(led_vertices_.begin(), led_vertices_.end(), v) &&
                std::find(vertices.begin(), vertices.end(), v) == vertices.end() &&
                is_free_without(own, rerouted.contour.structure, v))
                free(v, done);
        }
    }

    // The end of the subsegment that leads on from v along the segment from a to b.
    std::uint32_t end_of_subsegment(std::uint32_t v, std::uint32_t a, std::uint32_t b,
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
    bool is_free_without(const std::vector<std::uint32_t>& own, std::uint32_t structure,
                         std::uint32_t v) const {
        const auto subsegments = drawn_.owners->subsegments_at(v);
        return edit_.constraints.fixed(v) && !subsegments.empty() &&
               std::all_of(subsegments.begin(), subsegments.end(),
                           [&](const ContourOwners::Subsegment& subsegment) {
                               return subsegment.structure == structure &&
                                      std::binary_search(own.begin(), own.end(), subsegment.other);
                           });
    }

    void free(std::uint32_t v, Attempt& done) {
        edit_.constraints.unfix(v);
        done.released.push_back(v);
        done.constraint_limited.push_back(
            v < constraint_limited_.size() ? std::exchange(constraint_limited_[v], std::uint8_t{0}) : 0);
        edit_.mesh.star(v, edit_.star);
        done.changed.insert(done.changed.end(), edit_.star.begin(), edit_.star.end());
    }

    void improve_cells(Attempt& done) {
        sort_distinct(done.changed);
        const std::vector<std::uint32_t> improved = improve_(done.changed);
        done.changed.insert(done.changed.end(), improved.begin(), improved.end());
        sort_distinct(done.changed);
    }

    bool is_good(std::uint32_t c) const {
        if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return true;
        const Cell& v = edit_.mesh.cell(c);
        const bool forced = drawn_.are_constraint_limited(v) || shortest_is_drawn(v);
        const CellMeasures m = measure_cell(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]),
                                            edit_.mesh.point(v[2]), edit_.mesh.point(v[3]));
        const double most = forced ? most_limited_ratio : edit_.options.last_radius_edge;
        return m.least_sine() >= (forced ? least_limited_sine : least_sine_) &&
               m.squared_ratio <= most * most;
    }

    // Whether the shortest edge of a cell joins two vertices of contours as they are drawn.
    bool shortest_is_drawn(const Cell& v) const {
        double shortest = HUGE_VAL;
        bool is_drawn = false;
        for (const auto& [i, j] : cell_edges) {
            const double edge = squared_length(edit_.mesh.point(v[i]) - edit_.mesh.point(v[j]));
            if (edge >= shortest) continue;
            shortest = edge;
            is_drawn = std::binary_search(drawn_vertices_.begin(), drawn_vertices_.end(), v[i]) &&
                       std::binary_search(drawn_vertices_.begin(), drawn_vertices_.end(), v[j]);
        }
        return is_drawn;
    }

    // Whether the contours of its slice are still what those of kept sets are.
    bool is_sound(const ReroutedContour& rerouted, const ContourLoop& changed) const {
        const Plane& plane = routable_.planes[rerouted.contour.slice];
        std::vector<PlaneRing> rings;
        for (std::uint32_t n = 0; n < routable_.contours.size(); ++n) {
            const Contour& contour = routable_.contours[n];
            if (contour.slice != rerouted.contour.slice) continue;
            PlaneRing& ring = rings.emplace_back(PlaneRing{contour.structure, {}});
            const auto found = std::find_if(contours_.begin(), contours_.end(),
                                            [&](const ReroutedContour& other) { return other.number == n; });
            const ContourLoop* const loop = n == rerouted.number       ? &changed
                                            : found != contours_.end() ? &found->loop
                                                                       : nullptr;
            const std::size_t count = loop ? loop->size() : contour.point_count;
            for (std::size_t k = 0; k < count; ++k) {
                const std::uint32_t v =
                    loop ? loop->corner(k).vertex : routable_.vertices[contour.first_point + k];
                ring.at.push_back(plane.to_plane(edit_.mesh.point(v)));
            }
        }
        return slice_faults(rings, routable_.exclusive).empty();
    }

    void take_back(const Attempt& done) {
        for (const std::uint32_t v : done.moved) edit_.constraints.unfix(v);
        for (std::size_t n = 0; n < done.released.size(); ++n) {
            edit_.constraints.fix(done.released[n]);
            if (done.released[n] < constraint_limited_.size())
                constraint_limited_[done.released[n]] = done.constraint_limited[n];
        }
        for (const VertexPair& edge : done.let_go) edit_.constraints.keep_edge(edge[0], edge[1]);
        for (const VertexPair& edge : done.fixed) edit_.constraints.unfix_edge(edge[0], edge[1]);
    }

    // `way`: its vertices.
    void keep(const Contour& contour, const std::vector<std::uint32_t>& way, const Attempt& done) {
        changed_.insert(changed_.end(), done.changed.begin(), done.changed.end());
        for (const std::uint32_t v : way) note(contour, v);
        led_vertices_.insert(led_vertices_.end(), way.begin(), way.end());
        sort_distinct(led_vertices_);
        sort_distinct(of_drawing_[drawing(contour)]);
        sort_distinct(of_slice_[contour.slice]);
        // What moved for an earlier way and is not on this one is free again.
        for (const std::uint32_t v : done.moved) {
            if (std::find(way.begin(), way.end(), v) == way.end()) edit_.constraints.unfix(v);
        }
    }

    EditContext& edit_;
    const DrawnSlices& drawn_;
    std::span<std::uint8_t> constraint_limited_;
    const RoutableContours& routable_;
    SurfaceIncidence incidence_;
    double least_sine_, last_sine_;  // of cells inside that no contour forces
    const ImproveCells& improve_;
    const RunContext& context_;
    std::size_t attempts_ = 0;
    std::map<std::array<std::uint32_t, 3>, Tried> tried_;  // by ends and contour
    std::vector<ReroutedContour> contours_;                // that have missed segments, by number
    // Vertices of the contours as they are now, rising: of a slice and a structure, and of a slice; and as
    // they are drawn.
    std::map<std::uint64_t, std::vector<std::uint32_t>> of_drawing_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> of_slice_;
    std::vector<std::uint32_t> drawn_vertices_, led_vertices_;  // these, of all ways; rising
    std::vector<std::uint32_t> changed_;                        // cells
};

}  // namespace

RerouteStats reroute_on_section(EditContext& edit, const DrawnSlices& drawn,
                                std::span<std::uint8_t> constraint_limited, double least_sine,
                                double last_sine, const ImproveCells& improve, const RunContext& context) {
    if (!drawn.table || !drawn.owners || drawn.routable.contours.empty() || !(drawn.routable.most_mm > 0))
        return {};
    return SectionRerouting(edit, drawn, constraint_limited, least_sine, last_sine, improve, context).run();
}

}  // namespace anatomesh
