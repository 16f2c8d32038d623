#include "anatomesh/improve/sections/repair_section_locally.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/failed_attempt_cache.h"
#include "anatomesh/improve/core/hole.h"
#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

constexpr double enough_less = 0.5;               // of the wrong share
constexpr std::uint64_t most_vain = 10'000;       // places: so many are of slices that contradict each other
constexpr double least_wrong_of_crossing = 1e-6;  // share of what is drawn: less is not repaired there
constexpr std::array height_shares{0.05, -0.05, 0.1,  -0.1, 0.2,
                                   -0.2, 0.35,  -0.35};  // of a moved vertex over the plane, in edges at it
constexpr std::array lifts{0.1, 0.2, 0.3, 0.45, 0.06, 0.03};  // of a new vertex, in heights of the cell
constexpr double radians_per_degree = std::numbers::pi / 180;
constexpr double before_moving = 0.5;  // of the least sine that an edge may be collapsed for
constexpr int moves_after_collapse = 3;
constexpr double most_turned = 0.5;  // cosine of a facet's turning

class LocalSectionRepair {
  public:
    LocalSectionRepair(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                       const RunContext& context)
        : edit_(edit),
          context_(context),
          areas_(edit, drawn),
          owners_(*drawn.owners),
          least_wrong_(drawn.extents.empty() ? 0 : least_wrong_of_crossing),
          bounds_{{{std::sin(edit.options.target_degrees * radians_per_degree), edit.options.max_radius_edge},
                   {least_sine, edit.options.max_radius_edge},
                   {least_sine, edit.options.last_radius_edge}}} {}

    // From these cells on, rising.
    LocalRepairStats run(std::vector<std::uint32_t> waiting) {
        repair_all(waiting, 1);
        // Those of cuts that still are further from what is drawn are worth worse cells. What a surface that
        // just passes through a plane makes wrong may lie in any cell that has a vertex of it.
        std::vector<std::uint32_t> passed = waiting;
        std::erase_if(passed, [&](std::uint32_t c) { return suspect_facet(c, 0) == 4; });
        areas_.sum_cuts_round(passed, context_.threads);
        repair_all(waiting, bounds_.size());
        std::erase_if(waiting, [&](std::uint32_t c) { return suspect_facet(c, 0) == 4; });
        stats_.left = std::move(waiting);
        return stats_;
    }

    // Those of all cells at which something may be wrong.
    std::vector<std::uint32_t> suspects(int threads) const {
        return parallel_collect<std::uint32_t>(
            edit_.mesh.cell_count(), 16384, threads,
            [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
                for (std::size_t c = first; c < last; ++c) {
                    if (suspect_facet(static_cast<std::uint32_t>(c), 0) < 4)
                        found.push_back(static_cast<std::uint32_t>(c));
                }
            });
    }

  private:
    // The first facet of the cell from that on that passes through a plane or lies in it, and is between
    // regions, or, in it, in one beside others; 4: none.
    int suspect_facet(std::uint32_t c, int from) const {
        if (!edit_.mesh.alive(c)) return 4;
        std::array<bool, 4> between{};
        for (int i = 0; i < 4; ++i) {
            const std::uint32_t other = edit_.mesh.neighbor(c, i);
            between[i] = other != no_cell && edit_.mesh.region(other) != edit_.mesh.region(c);
        }
        if (std::find(between.begin(), between.end(), true) == between.end()) return 4;
        const Cell& cell = edit_.mesh.cell(c);
        for (int i = from; i < 4; ++i) {
            if (edit_.mesh.neighbor(c, i) == no_cell) continue;
            const auto& f = facet_vertices[i];
            const std::array facet{cell[f[0]], cell[f[1]], cell[f[2]]};
            if ((between[i] && areas_.passes_between(facet)) || areas_.plane_of(facet) != no_slice) return i;
        }
        return 4;
    }

    // What new cells inside must keep.
    struct Bounds {
        double sine, ratio;
    };

    // Within the first so many bounds; `waiting` grows by the cells to be looked at again.
    void repair_all(std::vector<std::uint32_t>& waiting, std::size_t count) {
        std::uint64_t vain = 0;
        for (std::size_t n = 0; n < waiting.size() && vain < most_vain; ++n) {
            if (context_.cancelled()) return;
            const std::uint32_t c = waiting[n];
            for (int i = suspect_facet(c, 0); i < 4; i = suspect_facet(c, i + 1)) {
                if (!(wrong_at(c, i) > least_wrong_)) continue;
                ++stats_.places_found;
                if (count > 1 && areas_.largest_cut_at(c, i) < much_of_cut) continue;
                if (!repair(c, i, count)) {
                    ++vain;
                    continue;
                }
                stats_.changed.insert(stats_.changed.end(), edit_.changed.begin(), edit_.changed.end());
                failed_.note_change(edit_.mesh, edit_.changed);
                for (const std::uint32_t changed : edit_.changed) {
                    if (suspect_facet(changed, 0) < 4) waiting.push_back(changed);
                }
                break;
            }
        }
    }

    // Of the facet alone where it lies in one region: what cells beside it have wrong is found at others.
    double wrong_at(std::uint32_t c, int i) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        return edit_.mesh.region(other) == edit_.mesh.region(c) ? areas_.wrong_in_plane(c, i)
                                                                : areas_.wrong_at(c, i);
    }

    bool repair(std::uint32_t c, int i, std::size_t count) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        if (edit_.mesh.region(other) == edit_.mesh.region(c)) {
            return std::any_of(bounds_.begin(), bounds_.begin() + static_cast<std::ptrdiff_t>(count),
                               [&](const Bounds& bounds) { return relabel_both(c, other, bounds); });
        }
        std::vector<std::uint32_t> vertices(edit_.mesh.cell(c).begin(), edit_.mesh.cell(c).end());
        for (const std::uint32_t v : edit_.mesh.cell(other)) {
            if (std::find(vertices.begin(), vertices.end(), v) == vertices.end()) vertices.push_back(v);
        }
        const Region here = edit_.mesh.region(c), there = edit_.mesh.region(other);
        const auto last = bounds_.begin() + static_cast<std::ptrdiff_t>(count);
        return std::any_of(bounds_.begin(), last, [&](const Bounds& bounds) {
            return std::any_of(vertices.begin(), vertices.end(),
                               [&](std::uint32_t v) { return move_unless_tried(v, bounds); }) ||
                   relabel_unless_tried(c, there, bounds) || relabel_unless_tried(other, here, bounds) ||
                   flip(c, i, bounds) || collapse(c, i, bounds) || fill(c, i, bounds) ||
                   (count > 1 && (lift_off(c, there, bounds) || lift_off(other, here, bounds)));
        });
    }

    enum class Operation : std::uint32_t { move, lift_off, collapse, relabel, flip };

    // Unless it was in vain since the cells at these vertices have changed; cells at several facets share
    // vertices, edges and cells.
    template <class Operate>
    bool try_anew(Operation operation, const Bounds& bounds, std::array<std::uint32_t, 3> of,
                  std::span<const std::uint32_t> vertices, const Operate& operate) {
        const auto bound = static_cast<std::uint32_t>(&bounds - bounds_.data());
        const FailedAttemptCache::Name name{static_cast<std::uint32_t>(operation) * 16 + bound, of[0], of[1],
                                            of[2]};
        if (failed_.contains(name, vertices)) return false;
        if (operate()) return true;
        failed_.add(name);
        return false;
    }

    bool move_unless_tried(std::uint32_t v, const Bounds& bounds) {
        return try_anew(Operation::move, bounds, {v, 0, 0}, std::array{v}, [&] { return move(v, bounds); });
    }

    bool relabel_unless_tried(std::uint32_t c, Region to, const Bounds& bounds) {
        return try_anew(Operation::relabel, bounds, {c, to, 0}, edit_.mesh.cell(c),
                        [&] { return relabel(c, to, bounds); });
    }

    struct Facet {
        Vec3 b, c;
        Region here, there;
        double most;
    };

    // To a place over or under a plane that its cells meet.
    bool move(std::uint32_t v, const Bounds& bounds) {
        const bool again = edit_.constraints.settled(v);
        if (edit_.constraints.fixed(v) && !again) return false;
        edit_.mesh.star(v, edit_.star);
        const double before = areas_.wrong_round(v, edit_.star);
        if (!(before > least_wrong_)) return false;
        double edges = 0;
        std::size_t count = 0;
        const Vec3 from = edit_.mesh.point(v);
        std::vector<std::uint32_t> round;
        for (const std::uint32_t c : edit_.star) {
            for (const std::uint32_t u : edit_.mesh.cell(c)) {
                round.push_back(u);
                if (u == v) continue;
                edges += length(edit_.mesh.point(u) - from);
                ++count;
            }
        }
        sort_distinct(round);
        const double edge = edges / static_cast<double>(count);
        const QualityThreshold threshold = edit_.threshold_of(edit_.star);
        const std::vector<Facet> facets = facets_at(v);
        const std::vector<std::uint32_t> star = edit_.star;
        edit_.scratch.local.reset(edit_.rule.needed_outside_sine(threshold), bounds.ratio * bounds.ratio);
        for (const std::uint32_t c : star) {
            const Cell& cell = edit_.mesh.cell(c);
            const auto& f = facet_vertices[std::find(cell.begin(), cell.end(), v) - cell.begin()];
            edit_.scratch.local.add(edit_.mesh.point(cell[f[0]]), edit_.mesh.point(cell[f[1]]),
                                    edit_.mesh.point(cell[f[2]]), edit_.mesh.region(c) != 0);
        }
        const auto near = [&](Vec3& q) { return keeps_near(q, from, facets); };
        return areas_.any_plane_at(round, [&](std::uint32_t k) {
            if (!(areas_.wrong_round(v, star, k) > least_wrong_)) return false;
            const Plane& plane = areas_.plane(k);
            for (const double share : height_shares) {
                Vec3 p = from + (share * edge - plane.signed_distance(from)) * plane.normal;
                if (!near(p)) continue;
                if (edit_.scratch.local.ascend(p, edit_.scratch.local.worst(p, -2), edit_.goal, plane.normal,
                                               near) < bounds.sine)
                    continue;
                edit_.mesh.move_point(v, p);
                if (edit_.positive(star) && areas_.wrong_round(v, star) <= enough_less * before) {
                    edit_.changed = star;
                    again ? edit_.constraints.fix(v) : edit_.constraints.settle(v);
                    ++stats_.vertices_moved;
                    return true;
                }
                edit_.mesh.move_point(v, from);
            }
            return false;
        });
    }

    // Those between regions at the vertex whose star the context has.
    std::vector<Facet> facets_at(std::uint32_t v) {
        std::vector<Facet> facets;
        const Vec3 p = edit_.mesh.point(v);
        for (const std::uint32_t c : edit_.star) {
            const Cell& cell = edit_.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t n = edit_.mesh.neighbor(c, i);
                if (cell[i] == v || n == no_cell || n < c || edit_.mesh.region(n) == edit_.mesh.region(c))
                    continue;
                const auto [u, w] = others_of_facet(cell, i, v);
                const Region here = edit_.mesh.region(c), there = edit_.mesh.region(n);
                edit_.look_between(here, there);
                const Vec3 b = edit_.mesh.point(u), d = edit_.mesh.point(w);
                facets.push_back(
                    {b, d, here, there, std::max(edit_.facet_distance(p, b, d), edit_.options.spike_mm)});
            }
        }
        return facets;
    }

    bool keeps_near(Vec3 q, Vec3 from, const std::vector<Facet>& facets) {
        return std::all_of(facets.begin(), facets.end(), [&](const Facet& f) {
            const Vec3 before = cross(f.b - from, f.c - from), after = cross(f.b - q, f.c - q);
            if (!(dot(before, after) > most_turned * length(before) * length(after))) return false;
            edit_.look_between(f.here, f.there);
            return edit_.facet_distance(q, f.b, f.c) <= f.most;
        });
    }

    bool relabel(std::uint32_t c, Region to, const Bounds& bounds) {
        const Region own = edit_.mesh.region(c);
        const std::array cells{c};
        const double before = areas_.wrong(cells);
        if (!(before > 0) || !may_relabel(edit_, c, to, owners_, bounds.sine, bounds.ratio)) return false;
        edit_.mesh.set_region(c, to);
        if (areas_.wrong(cells) <= enough_less * before) {
            edit_.changed.assign(1, c);
            for (int i = 0; i < 4; ++i) edit_.changed.push_back(edit_.mesh.neighbor(c, i));
            ++stats_.cells_relabelled;
            return true;
        }
        edit_.mesh.set_region(c, own);
        return false;
    }

    // The cells on both sides of a facet in a plane, to a region beside them.
    bool relabel_both(std::uint32_t c, std::uint32_t other, const Bounds& bounds) {
        const Region own = edit_.mesh.region(c);
        const std::array cells{c, other};
        const double before = areas_.wrong(cells);
        for (const std::uint32_t side : cells) {
            for (int i = 0; i < 4; ++i) {
                if (edit_.mesh.neighbor(side, i) == no_cell) return false;
                const Region to = edit_.mesh.region(edit_.mesh.neighbor(side, i));
                if (to == own || !may_relabel_all(edit_, cells, to, owners_, bounds.sine, bounds.ratio))
                    continue;
                for (const std::uint32_t relabelled : cells) edit_.mesh.set_region(relabelled, to);
                if (areas_.wrong(cells) <= enough_less * before) {
                    edit_.changed.assign(cells.begin(), cells.end());
                    for (const std::uint32_t relabelled : cells) {
                        for (int k = 0; k < 4; ++k)
                            edit_.changed.push_back(edit_.mesh.neighbor(relabelled, k));
                    }
                    stats_.cells_relabelled += cells.size();
                    return true;
                }
                for (const std::uint32_t relabelled : cells) edit_.mesh.set_region(relabelled, own);
            }
        }
        return false;
    }

    // The ends of a cell's edge, if it is one of the facet and between vertices on both sides of a plane;
    // else no_cell.
    std::array<std::uint32_t, 2> edge_across(std::uint32_t c, int i, int e) const {
        const auto [a, b] = cell_edges[static_cast<std::size_t>(e)];
        const Cell& cell = edit_.mesh.cell(c);
        const std::array ends{cell[a], cell[b]};
        if (a == i || b == i || !areas_.passes_between(ends)) return {no_cell, no_cell};
        return ends;
    }

    // The facet's edge between vertices on both sides of a plane.
    bool flip(std::uint32_t c, int i, const Bounds& bounds) {
        for (int e = 0; e < 6; ++e) {
            const auto [a, b] = edge_across(c, i, e);
            if (a == no_cell || edit_.constraints.fixed_edge(a, b)) continue;
            const std::array ends{std::min(a, b), std::max(a, b)};
            if (try_anew(Operation::flip, bounds, {ends[0], ends[1], 0}, ends,
                         [&] { return flip_across(c, e, bounds); }))
                return true;
        }
        return false;
    }

    bool flip_across(std::uint32_t c, int e, const Bounds& bounds) {
        edit_.mesh.ring(c, e, edit_.ring);
        const std::vector<std::uint32_t> round = edit_.ring.cells;
        if (!try_exchange(round, [&] { return flip_edge(edit_, c, e, bounds.sine); })) return false;
        ++stats_.edges_flipped;
        return true;
    }

    // A free vertex of the facet goes along an edge that passes through a plane.
    bool collapse(std::uint32_t c, int i, const Bounds& bounds) {
        for (int e = 0; e < 6; ++e) {
            const auto [a, b] = edge_across(c, i, e);
            if (a == no_cell) continue;
            for (const bool first_onto_second : {true, false}) {
                const std::uint32_t from = first_onto_second ? a : b, to = first_onto_second ? b : a;
                if (edit_.constraints.fixed(from)) continue;
                const std::array ends{from, to};
                if (try_anew(Operation::collapse, bounds, {from, to, 0}, ends,
                             [&] { return collapse_along(c, e, first_onto_second, ends, bounds); }))
                    return true;
            }
        }
        return false;
    }

    bool collapse_along(std::uint32_t c, int e, bool first_onto_second,
                        const std::array<std::uint32_t, 2>& ends, const Bounds& bounds) {
        const auto [from, to] = ends;
        const std::vector<std::uint32_t> round = stars(from, to);
        const std::size_t bad = count_bad(round, bounds);
        const auto operation = [&, to = to] {
            return collapse_onto(c, e, first_onto_second, to, bounds) &&
                   count_bad(edit_.changed, bounds) <= bad;
        };
        if (!try_exchange(round, operation)) return false;
        if (!edit_.constraints.fixed(to)) edit_.constraints.settle(to);
        ++stats_.edges_collapsed;
        return true;
    }

    // The cells at either of two vertices.
    std::vector<std::uint32_t> stars(std::uint32_t a, std::uint32_t b) {
        std::vector<std::uint32_t> cells, more;
        edit_.mesh.star(a, cells);
        edit_.mesh.star(b, more);
        for (const std::uint32_t c : more) {
            if (std::find(cells.begin(), cells.end(), c) == cells.end()) cells.push_back(c);
        }
        return cells;
    }

    // Cells inside that do not keep the bounds.
    std::size_t count_bad(const std::vector<std::uint32_t>& cells, const Bounds& bounds) const {
        return static_cast<std::size_t>(std::count_if(cells.begin(), cells.end(), [&](std::uint32_t c) {
            if (edit_.mesh.region(c) == 0) return false;
            const Cell& v = edit_.mesh.cell(c);
            const CellMeasures m = measure_cell(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]),
                                                edit_.mesh.point(v[2]), edit_.mesh.point(v[3]));
            return m.least_sine() < bounds.sine || m.squared_ratio > bounds.ratio * bounds.ratio;
        }));
    }

    // The vertex that stays may move where cells at it are too flat then.
    bool collapse_onto(std::uint32_t c, int e, bool first_onto_second, std::uint32_t to,
                       const Bounds& bounds) {
        edit_.mesh.star(to, edit_.scratch.others);
        const double sine = std::min(bounds.sine, edit_.threshold_of(edit_.scratch.others).sine);
        if (!collapse_edge_within(edit_, c, e, first_onto_second, before_moving * bounds.sine, bounds.ratio))
            return false;
        for (int n = 0; n < moves_after_collapse; ++n) {
            edit_.mesh.star(to, edit_.changed);
            if (edit_.threshold_of(edit_.changed).sine >= sine) return true;
            if (!move_vertex(edit_, to)) return false;
        }
        edit_.mesh.star(to, edit_.changed);
        return edit_.threshold_of(edit_.changed).sine >= sine;
    }

    // An operation that exchanges these cells; taken back unless the cuts gain enough.
    template <class Operation>
    bool try_exchange(const std::vector<std::uint32_t>& round, const Operation& operation) {
        const double before = areas_.wrong(round);
        edit_.mesh.begin_attempt();
        const bool done = operation() && areas_.wrong(edit_.changed) <= enough_less * before;
        edit_.mesh.end_attempt(done);
        return done;
    }

    // A facet in a plane goes, and the cells on both sides with it.
    bool fill(std::uint32_t c, int i, const Bounds& bounds) {
        const std::uint32_t other = edit_.mesh.neighbor(c, i);
        const Cell cell = edit_.mesh.cell(c);
        const auto& f = facet_vertices[i];
        const std::uint32_t k = areas_.plane_of(std::array{cell[f[0]], cell[f[1]], cell[f[2]]});
        if (k == no_slice) return false;
        const Vec3 a = edit_.mesh.point(cell[f[0]]), b = edit_.mesh.point(cell[f[1]]),
                   d = edit_.mesh.point(cell[f[2]]);
        const Vec3 foot = (1.0 / 3) * (a + b + d);
        const double before = areas_.wrong_at(c, i);
        const auto enough = [&](const QualityThreshold&) { return bounds.sine; };
        for (const std::uint32_t side : {c, other}) {
            const Vec3 top = edit_.mesh.point(apex_of(side, cell, i));
            // Then the plane has there what is on the other side.
            const std::uint32_t under = side == c ? other : c;
            if (areas_.wrong_facet(a, b, d, k, edit_.mesh.region(under), edit_.mesh.region(under)) >
                enough_less * before)
                continue;
            const auto above = [&](Vec3& q) {
                return areas_.plane(k).signed_distance(q) * areas_.plane(k).signed_distance(top) > 0;
            };
            for (const double share : lifts) {
                const auto v = static_cast<std::uint32_t>(edit_.mesh.point_count());
                if (!Hole(edit_, {c, other}, {})
                         .fill(foot + share * (top - foot), {}, bounds.ratio, enough, above))
                    continue;
                edit_.constraints.settle(v);
                ++stats_.vertices_inserted;
                return true;
            }
        }
        return false;
    }

    // The surface leaves a free vertex of the cell that lies beyond a plane, on to a new vertex this side of
    // it: the vertex's cells of the cell's region are filled from there, those at the surface for the region
    // `to`.
    bool lift_off(std::uint32_t c, Region to, const Bounds& bounds) {
        const Cell cell = edit_.mesh.cell(c);
        return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
            const Region own = edit_.mesh.region(c);
            return (!edit_.constraints.fixed(v) || edit_.constraints.settled(v)) &&
                   try_anew(Operation::lift_off, bounds, {v, own, to}, std::array{v},
                            [&] { return lift_off_vertex(v, own, to, bounds); });
        });
    }

    bool lift_off_vertex(std::uint32_t v, Region own, Region to, const Bounds& bounds) {
        std::vector<std::uint32_t> star, cells, round;
        edit_.mesh.star(v, star);
        std::copy_if(star.begin(), star.end(), std::back_inserter(cells),
                     [&](std::uint32_t c) { return edit_.mesh.region(c) == own; });
        std::vector<Hole::CellFacet> at_surface;
        for (const std::uint32_t c : cells) {
            const Cell& cell = edit_.mesh.cell(c);
            for (int i = 0; i < 4; ++i) {
                const std::uint32_t beyond = edit_.mesh.neighbor(c, i);
                round.push_back(cell[i]);
                // A facet that does not have the vertex stays between what it lies between.
                if (cell[i] == v) continue;
                if (beyond == no_cell) return false;
                if (edit_.mesh.region(beyond) == own) continue;
                if (edit_.mesh.region(beyond) != to) return false;
                at_surface.push_back({c, i});
            }
        }
        if (at_surface.empty()) return false;
        const double before = areas_.wrong(cells);
        if (!(before > least_wrong_)) return false;
        sort_distinct(round);
        return areas_.any_plane_at(round, [&](std::uint32_t k) {
            const int side = areas_.side(v, k);
            return (side <= 0 && lift_to(1, v, k, cells, at_surface, before, bounds)) ||
                   (side >= 0 && lift_to(-1, v, k, cells, at_surface, before, bounds));
        });
    }

    // To a place over the plane, or, with -1, under it.
    bool lift_to(double over, std::uint32_t v, std::uint32_t k, const std::vector<std::uint32_t>& cells,
                 const std::vector<Hole::CellFacet>& at_surface, double before, const Bounds& bounds) {
        const Vec3 from = edit_.mesh.point(v), normal = areas_.plane(k).normal;
        const double depth = areas_.plane(k).signed_distance(from);
        double edges = 0;
        for (const std::uint32_t c : cells) {
            for (const std::uint32_t u : edit_.mesh.cell(c)) edges += length(edit_.mesh.point(u) - from);
        }
        const double edge = edges / (3.0 * static_cast<double>(cells.size()));
        const Region own = edit_.mesh.region(cells.front()),
                     to = edit_.mesh.region(
                         edit_.mesh.neighbor(at_surface.front().first, at_surface.front().second));
        const double most = edit_.options.spike_mm;
        const auto may_lie = [&](Vec3& q) {
            edit_.look_between(own, to);
            return over * areas_.plane(k).signed_distance(q) > 0 && edit_.probe.distance(q, most) <= most;
        };
        const auto enough = [&](const QualityThreshold&) { return bounds.sine; };
        for (const double share : lifts) {
            const Vec3 p = from + (over * share * edge - depth) * normal;
            const auto added = static_cast<std::uint32_t>(edit_.mesh.point_count());
            edit_.mesh.begin_attempt();
            const bool done = Hole(edit_, cells, at_surface).fill(p, normal, bounds.ratio, enough, may_lie) &&
                              areas_.wrong(edit_.changed) <= enough_less * before;
            edit_.mesh.end_attempt(done);
            if (!done) continue;
            edit_.constraints.settle(added);
            ++stats_.vertices_inserted;
            return true;
        }
        return false;
    }

    std::uint32_t apex_of(std::uint32_t side, const Cell& cell, int i) const {
        const auto& f = facet_vertices[i];
        for (const std::uint32_t v : edit_.mesh.cell(side)) {
            if (v != cell[f[0]] && v != cell[f[1]] && v != cell[f[2]]) return v;
        }
        return no_cell;
    }

    EditContext& edit_;
    const RunContext& context_;
    SectionAreas areas_;
    const ContourOwners& owners_;
    double least_wrong_;
    std::array<Bounds, 3> bounds_;
    LocalRepairStats stats_;
    FailedAttemptCache failed_;
};

}  // namespace

LocalRepairStats repair_section_locally(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                        const RunContext& context, const std::vector<std::uint32_t>* look) {
    if (!drawn.table || !drawn.owners || drawn.planes.empty()) return {};
    LocalSectionRepair section_repair(edit, drawn, least_sine, context);
    if (!look) return section_repair.run(section_repair.suspects(context.threads));
    std::vector<std::uint32_t> cells = *look;
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    return section_repair.run(std::move(cells));
}

}  // namespace anatomesh
