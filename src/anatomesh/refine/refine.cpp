#include "anatomesh/refine/refine.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/cull/cull.h"
#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

// Points of one round keep this distance from each other. [circumradii; 0 to 1; M 2026-11, set not recorded]
constexpr double spread = 0.7;
// A facet near another structure's surface deviates if it is so far from its own.
// [bounds; >= 1; M 2026-11 22 random label maps]
constexpr double far_off = 5;
// Cells with circumradii of more shortest edges wait where a point was chosen. [shortest edges; > 0; B]
constexpr double far = 8;
// So many cells choose their points without knowing of each other. [cells; >= 1; B]
constexpr std::size_t batch = 2048;

struct BadCell {
    std::uint32_t cell = 0;
    double ratio = 0;
    bool flat = false;
    double shortest = 0, radius = 0;
    Vec3 center;                // where a point takes it away
    std::optional<Vec3> point;  // to insert
    bool on_surface = false;
    bool waits = false;                               // for another round
    std::uint32_t ball = ProtectedSegments::no_ball;  // of a subsegment to split instead
};

// Six volumes in cubes of the longest edge; 0.71 for the regular cell.
double flatness_of(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const double longest = std::max({squared_length(b - a), squared_length(c - a), squared_length(d - a),
                                     squared_length(c - b), squared_length(d - b), squared_length(d - c)});
    return 6 * signed_volume(a, b, c, d) / (longest * std::sqrt(longest));
}

Vec3 triangle_circumcenter(Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 u = b - a, v = c - a, n = cross(u, v);
    return a + (1.0 / (2.0 * squared_length(n))) *
                   (squared_length(v) * cross(n, u) + squared_length(u) * cross(v, n));
}

Vec3 largest_facet_center(const std::array<Vec3, 4>& p) {
    double largest = -1;
    Vec3 center;
    for (const auto& f : facet_vertices) {
        const Vec3 a = p[f[0]], b = p[f[1]], c = p[f[2]];
        const double area = squared_length(cross(b - a, c - a));
        if (area <= largest) continue;
        largest = area;
        center = triangle_circumcenter(a, b, c);
    }
    return center;
}

double shortest_edge(const std::vector<Vec3>& points, const Cell& cell) {
    double squared = squared_length(points[cell[0]] - points[cell[1]]);
    for (const auto& [i, j] : cell_edges)
        squared = std::min(squared, squared_length(points[cell[i]] - points[cell[j]]));
    return std::sqrt(squared);
}

// Whether the shortest edge joins two contour vertices, and the circumradius is within the bound for an edge
// of the length below which such vertices crowd each other.
bool is_crowded(const std::vector<Vec3>& points, const Cell& cell, double ratio,
                const RefineOptions& options) {
    const auto is_given = [&](std::uint32_t v) { return v < options.given.size() && options.given[v] != 0; };
    double shortest = HUGE_VAL;
    bool between_given = false;
    for (const auto& [i, j] : cell_edges) {
        const double squared = squared_length(points[cell[i]] - points[cell[j]]);
        if (squared >= shortest) continue;
        shortest = squared;
        between_given = is_given(cell[i]) && is_given(cell[j]);
    }
    return between_given && ratio * std::sqrt(shortest) <= options.max_radius_edge * options.crowded_mm;
}

void aim(const std::vector<Vec3>& points, const Cell& cell, const RefineOptions& options, BadCell& bad) {
    const Vec3 a = points[cell[0]], b = points[cell[1]], c = points[cell[2]], d = points[cell[3]];
    bad.shortest = shortest_edge(points, cell);
    bad.center = bad.flat ? largest_facet_center({a, b, c, d}) : circumcenter(a, b, c, d);
    bad.radius = std::min(length(bad.center - a), options.max_reach_mm);
}

// The point to insert: where the cell aims, or on an interface before or near that.
void choose_point(const std::vector<Vec3>& points, const Cell& cell, InterfaceProbe& probe,
                  const OccupiedSpace& occupied, const RefineOptions& options, BadCell& bad) {
    const Vec3 centroid = 0.25 * (points[cell[0]] + points[cell[1]] + points[cell[2]] + points[cell[3]]);
    const double tolerance = 1e-3 * bad.shortest;
    std::optional<Vec3> on_surface =
        probe.first_crossing(centroid, bad.center, 0.5 * bad.shortest, tolerance);
    if (!on_surface && probe.distance(bad.center) < options.surface_pull * bad.radius) {
        on_surface = probe.project(bad.center, options.surface_pull * bad.radius, tolerance);
    }
    bad.on_surface = on_surface.has_value();
    if (!on_surface) on_surface = bad.center;
    // Rounding and the points of earlier rounds can bring even a circumcentre close to a vertex.
    if (occupied.vertices.any_within(*on_surface, options.min_spacing * bad.shortest)) return;
    const std::uint32_t ball = occupied.protected_segments.ball_at(*on_surface, options.protected_share);
    if (ball == ProtectedSegments::no_ball) {
        bad.point = on_surface;
    } else if (occupied.protected_segments.ball_radius(ball) > 0.5 * bad.shortest) {
        bad.ball = ball;
    }
}

// A facet of an interface, as one of the cell in the region with the larger number.
struct InterfaceFacet {
    std::uint32_t cell;
    std::uint32_t index;
    friend auto operator<=>(const InterfaceFacet&, const InterfaceFacet&) = default;
};

// Those of the cells looked at (rising), from either side; rising.
std::vector<InterfaceFacet> interface_facets(const LabelledMeshView& mesh,
                                             const std::vector<std::uint32_t>& look, int threads) {
    const std::vector<Region>& regions = mesh.regions;
    struct Found {
        InterfaceFacet facet;
        bool from_beyond;  // from its other cell, where its own is not looked at
    };
    const bool look_at_all = look.size() == mesh.cells.size();
    const std::vector<Found> found = parallel_collect<Found>(
        look.size(), 16384, threads, [&](std::size_t first, std::size_t last, std::vector<Found>& out) {
            for (std::size_t k = first; k < last; ++k) {
                const std::uint32_t c = look[k];
                for (std::uint32_t i = 0; i < 4; ++i) {
                    const std::uint32_t n = mesh.neighbors[c][i];
                    if (n == no_cell || regions[c] == regions[n]) continue;
                    if (regions[c] > regions[n]) {
                        out.push_back({{c, i}, false});
                    } else if (!look_at_all && !std::binary_search(look.begin(), look.end(), n)) {
                        const auto& back = mesh.neighbors[n];
                        const auto place = std::find(back.begin(), back.end(), c) - back.begin();
                        out.push_back({{n, static_cast<std::uint32_t>(place)}, true});
                    }
                }
            }
        });
    // Those found from their own cells rise as these do.
    std::vector<InterfaceFacet> own, beyond, facets;
    for (const Found& f : found) (f.from_beyond ? beyond : own).push_back(f.facet);
    std::sort(beyond.begin(), beyond.end());
    std::merge(own.begin(), own.end(), beyond.begin(), beyond.end(), std::back_inserter(facets));
    return facets;
}

using Edge = std::array<std::uint32_t, 2>;

// The edges of the cells looked at that cross something, rising; `look` is left with their cells.
template <class Crosses>
std::vector<Edge> crossing_edges(const LabelledMeshView& mesh, std::vector<std::uint32_t>& look,
                                 const Crosses& crosses, int threads) {
    look = parallel_collect<std::uint32_t>(
        look.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& out) {
            for (std::size_t n = first; n < last; ++n) {
                const Cell& cell = mesh.cells[look[n]];
                if (std::any_of(cell_edges.begin(), cell_edges.end(),
                                [&](auto& e) { return crosses(cell[e[0]], cell[e[1]]); })) {
                    out.push_back(look[n]);
                }
            }
        });
    std::vector<Edge> edges;
    for (const std::uint32_t c : look) {
        for (const auto& [i, j] : cell_edges) {
            const std::uint32_t a = std::min(mesh.cells[c][i], mesh.cells[c][j]),
                                b = std::max(mesh.cells[c][i], mesh.cells[c][j]);
            if (crosses(a, b)) edges.push_back({a, b});
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

// Where an edge crosses the surface that parts its ends.
std::optional<Vec3> crossing_of(InterfaceProbe& probe, const LabelledMeshView& mesh, std::uint32_t a,
                                std::uint32_t b) {
    const Vec3 p = mesh.points[a], q = mesh.points[b];
    const VertexMembership &from = mesh.memberships[a], &to = mesh.memberships[b];
    const double span = length(q - p);
    const auto crossing_from = [&](Vec3 start, Vec3 end) {
        return probe.first_crossing(start, end, 0.25 * span, 1e-3 * span);
    };
    if (from.off_interfaces() && to.off_interfaces()) {
        probe.focus({});
        return crossing_from(p, q);
    }
    if (!mesh.field.exclusive()) {
        probe.focus(std::array{*parted_by(mesh.table, from, to)});
        return crossing_from(p, q);
    }
    // The crossing lies between the middle and the end whose membership does not allow the middle's region.
    probe.focus({});
    const Vec3 middle = 0.5 * (p + q);
    return crossing_from(middle, allows(mesh.table, from, probe.members(middle)) ? q : p);
}

// The cells of `look` with a ratio above the bound, and those that are nearly flat; in the order of `look`.
// `radius_edge_mean` receives the mean of the cells inside.
std::vector<BadCell> bad_cells(const LabelledMeshView& mesh, const RefineOptions& options,
                               const std::vector<std::uint32_t>& look, double& radius_edge_mean,
                               int threads) {
    const std::vector<Vec3>& points = mesh.points;
    // Blocks of a fixed size keep the mean the same at any thread count.
    struct Inside {
        std::uint64_t cells = 0;
        double ratios = 0;
    };
    // So many cells are looked at in one task; sums go by it, so it is the same for any number of threads.
    // [cells at a time; >= 1; B]
    constexpr std::size_t grain = 8192;
    std::vector<Inside> inside(look.size() / grain + 1);
    std::vector<BadCell> bad = parallel_collect<BadCell>(
        look.size(), grain, threads, [&](std::size_t first, std::size_t last, std::vector<BadCell>& out) {
            Inside& here = inside[first / grain];
            for (std::size_t n = first; n < last; ++n) {
                if (n + cells_ahead < last) prefetch_points(points, mesh.cells[look[n + cells_ahead]]);
                const std::uint32_t c = look[n];
                const Cell& cell = mesh.cells[c];
                const bool is_inside = mesh.regions[c] != 0;
                if (!is_inside && std::none_of(cell.begin(), cell.end(), [&](std::uint32_t v) {
                        return !mesh.memberships[v].off_interfaces();
                    })) {
                    continue;
                }
                const Vec3 p = points[cell[0]], q = points[cell[1]], r = points[cell[2]], s = points[cell[3]];
                const bool flat = flatness_of(p, q, r, s) < options.flatness;
                if (!is_inside && !flat) continue;
                const double ratio = radius_edge_ratio(p, q, r, s);
                if (is_inside && !flat) {
                    ++here.cells;
                    here.ratios += ratio;
                }
                if (flat || (ratio > options.max_radius_edge && !is_crowded(points, cell, ratio, options))) {
                    out.emplace_back();
                    out.back().cell = c;
                    out.back().ratio = flat ? 0 : ratio;
                    out.back().flat = flat;
                }
            }
        });
    Inside all;
    for (const Inside& block : inside) {
        all.cells += block.cells;
        all.ratios += block.ratios;
    }
    radius_edge_mean = all.ratios / static_cast<double>(std::max<std::uint64_t>(1, all.cells));
    return bad;
}

}  // namespace

RefineStats find_refinement_points(const LabelledMeshView& mesh, const OccupiedSpace& occupied,
                                   const RefineOptions& options, std::vector<std::uint32_t>& look,
                                   std::vector<Vec3>& found, RunContext& context) {
    RefineStats stats;
    std::vector<BadCell> bad = bad_cells(mesh, options, look, stats.radius_edge_mean, context.threads);
    for (const BadCell& cell : bad) {
        stats.flat += cell.flat;
        stats.above_bound += !cell.flat && mesh.regions[cell.cell] != 0;
    }
    look.clear();
    for (const BadCell& cell : bad) look.push_back(cell.cell);

    parallel_for(bad.size(), 4096, context.threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) aim(mesh.points, mesh.cells[bad[n].cell], options, bad[n]);
    });
    // Worst first; one point for each neighbourhood a round.
    std::stable_sort(bad.begin(), bad.end(),
                     [](const BadCell& a, const BadCell& b) { return a.ratio > b.ratio; });
    double reach = 0;
    for (const BadCell& cell : bad) reach += cell.radius;
    PointGrid chosen(bad.empty() ? 1.0 : std::max(1e-300, reach / static_cast<double>(bad.size())),
                     bad.size());
    const auto is_taken = [&](Vec3 p, const BadCell& cell) {
        return chosen.any_within(p, spread * cell.radius);
    };
    // The way to a far place is long to search: not where a point is chosen already.
    const auto can_wait = [&](const BadCell& cell) {
        return cell.radius > far * cell.shortest && is_taken(cell.center, cell);
    };
    for (std::size_t begin = 0; begin < bad.size(); begin += batch) {
        const std::span<BadCell> now(bad.data() + begin, std::min(batch, bad.size() - begin));
        parallel_for(now.size(), 128, context.threads, [&](std::size_t first, std::size_t last) {
            InterfaceProbe probe(mesh.field, mesh.structures);
            for (std::size_t n = first; n < last; ++n) {
                now[n].waits = can_wait(now[n]);
                if (now[n].waits) continue;
                choose_point(mesh.points, mesh.cells[now[n].cell], probe, occupied, options, now[n]);
            }
        });
        for (const BadCell& cell : now) {
            if (cell.ball != ProtectedSegments::no_ball) stats.balls.push_back(cell.ball);
            stats.refused += !cell.point && !cell.waits;
            if (!cell.point || is_taken(*cell.point, cell)) continue;
            chosen.add(*cell.point);
            found.push_back(*cell.point);
            ++(cell.on_surface ? stats.surface_points : stats.circumcenters);
        }
    }
    sort_distinct(stats.balls);
    return stats;
}

CrossingStats find_crossing_points(const LabelledMeshView& mesh, const OccupiedSpace& occupied,
                                   const CrossingOptions& options, std::vector<std::uint32_t>& look,
                                   std::vector<Vec3>& found, RunContext& context) {
    const std::vector<Vec3>& points = mesh.points;
    const std::vector<VertexMembership>& memberships = mesh.memberships;
    CrossingStats stats;
    const auto crosses = [&](std::uint32_t a, std::uint32_t b) {
        if (memberships[a].off_interfaces() && memberships[b].off_interfaces())
            return memberships[a].interior_of != memberships[b].interior_of;
        return parted_by(mesh.table, memberships[a], memberships[b]).has_value() &&
               length(points[b] - points[a]) >= options.shortest_mm;
    };
    const std::vector<Edge> edges = crossing_edges(mesh, look, crosses, context.threads);
    stats.crossing_edges = edges.size();

    std::vector<std::optional<Vec3>> crossings(edges.size());
    std::vector<std::uint32_t> balls(edges.size(), ProtectedSegments::no_ball);
    parallel_for(edges.size(), 256, context.threads, [&](std::size_t first, std::size_t last) {
        InterfaceProbe probe(mesh.field, mesh.structures);
        for (std::size_t n = first; n < last; ++n) {
            const auto [a, b] = edges[n];
            const double span = length(points[b] - points[a]);
            const std::optional<Vec3> crossing = crossing_of(probe, mesh, a, b);
            if (!crossing || occupied.vertices.any_within(*crossing, options.min_spacing * span)) continue;
            const std::uint32_t ball =
                occupied.protected_segments.ball_at(*crossing, options.protected_share);
            if (ball == ProtectedSegments::no_ball) crossings[n] = crossing;
            if (memberships[a].off_interfaces() && memberships[b].off_interfaces()) balls[n] = ball;
        }
    });
    double total = 0;
    for (const auto& [a, b] : edges) total += length(points[b] - points[a]);
    PointGrid chosen(edges.empty() ? 1.0 : total / static_cast<double>(edges.size()), edges.size());
    for (std::size_t n = 0; n < edges.size(); ++n) {
        if (!crossings[n]) {
            ++stats.refused;
            continue;
        }
        const double span = length(points[edges[n][1]] - points[edges[n][0]]);
        if (chosen.any_within(*crossings[n], 0.5 * span)) continue;
        chosen.add(*crossings[n]);
        found.push_back(*crossings[n]);
    }
    for (const std::uint32_t ball : balls) {
        if (ball != ProtectedSegments::no_ball) stats.balls.push_back(ball);
    }
    sort_distinct(stats.balls);
    return stats;
}

DeviationStats find_deviation_points(const LabelledMeshView& mesh, const OccupiedSpace& occupied,
                                     const DeviationOptions& options, std::vector<std::uint32_t>& look,
                                     std::vector<Vec3>& found, RunContext& context) {
    const std::vector<Vec3>& points = mesh.points;
    DeviationStats stats;
    const std::vector<InterfaceFacet> facets = interface_facets(mesh, look, context.threads);
    struct Candidate {
        std::optional<Vec3> point;
        double longest = 0;
        bool deviates = false;
    };
    std::vector<Candidate> candidates(facets.size());
    parallel_for(facets.size(), 1024, context.threads, [&](std::size_t first, std::size_t last) {
        InterfaceProbe probe(mesh.field, mesh.structures);
        for (std::size_t n = first; n < last; ++n) {
            const auto& [owner, index] = facets[n];
            const auto& f = facet_vertices[index];
            const Cell& cell = mesh.cells[owner];
            const Vec3 a = points[cell[f[0]]], b = points[cell[f[1]]], c = points[cell[f[2]]];
            const Vec3 middle = (1.0 / 3.0) * (a + b + c);
            const std::uint32_t beyond = mesh.neighbors[owner][index];
            // Near another structure's surface than its own only a facet far off is worth a point.
            probe.focus({});
            if (probe.distance(middle, options.max_deviation_mm) <= options.max_deviation_mm) {
                if (mesh.structures == 1) continue;
                probe.focus_between(mesh.table.members[mesh.regions[owner]],
                                    mesh.table.members[mesh.regions[beyond]]);
                if (probe.distance(middle) <= far_off * options.max_deviation_mm) continue;
            }
            Candidate& candidate = candidates[n];
            candidate.deviates = true;
            candidate.longest =
                std::sqrt(std::max({squared_length(b - a), squared_length(c - b), squared_length(a - c)}));
            const double tolerance = 0.02 * options.max_deviation_mm;
            const auto keep_if_free = [&](const std::optional<Vec3>& p, double share) {
                if (!p || occupied.vertices.any_within(*p, options.min_spacing * candidate.longest)) return;
                if (occupied.protected_segments.ball_at(*p, share) == ProtectedSegments::no_ball)
                    candidate.point = p;
            };
            keep_if_free(probe.project(middle, candidate.longest, tolerance), 1);
            // The vertices opposite the facet in its two cells.
            const auto& back = mesh.neighbors[beyond];
            const auto across =
                static_cast<std::size_t>(std::find(back.begin(), back.end(), owner) - back.begin());
            for (const std::uint32_t apex : {cell[index], mesh.cells[beyond][across]}) {
                if (candidate.point) break;
                keep_if_free(probe.first_crossing(middle, points[apex], 0.25 * candidate.longest, tolerance),
                             options.protected_share);
            }
        }
    });
    double total = 0;
    look.clear();
    for (std::size_t n = 0; n < facets.size(); ++n) {
        if (candidates[n].deviates && (look.empty() || look.back() != facets[n].cell))
            look.push_back(facets[n].cell);
    }
    for (const Candidate& candidate : candidates) {
        stats.deviating += candidate.deviates;
        stats.refused += candidate.deviates && !candidate.point;
        total += candidate.longest;
    }
    PointGrid chosen(stats.deviating ? total / static_cast<double>(stats.deviating) : 1.0, stats.deviating);
    for (const Candidate& candidate : candidates) {
        if (!candidate.point || chosen.any_within(*candidate.point, 0.5 * candidate.longest)) continue;
        chosen.add(*candidate.point);
        found.push_back(*candidate.point);
    }
    return stats;
}

}  // namespace anatomesh
