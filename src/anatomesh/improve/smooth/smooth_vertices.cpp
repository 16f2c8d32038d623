#include "anatomesh/improve/smooth/smooth_vertices.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/parallel_filter.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh/improve/smooth/ratio_slopes.h"
#include "anatomesh/improve/smooth/star_ratios.h"
#include "anatomesh/improve/smooth/vertex_mover.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

// What a descent of the sum of ratios must be worth.
struct Worth {
    float look;   // steeper than this, for a way of an edge, a vertex is looked at
    double gain;  // for which it is moved
};
constexpr Worth usual_worth{0.15f, 0.005}, further_worth{0.03f, 0.001};
// The first step of a descent is as long. [mean edges at the vertex; 0 to 1; M 2026-11 skull at 3 mm, pelvis]
constexpr double step_share = 0.1;
// A descent goes no farther. [mean edges at the vertex; 0 to 1; M 2026-11 skull at 3 mm, pelvis]
constexpr double longest_move = 0.3;
// Descents of a vertex in a pass. [descents; > 0; B]
constexpr int descents = 4;
// A descent is made if the sum of ratios falls by more than this in a first step.
// [1; >= 0; M 2026-11 skull at 3 mm, pelvis]
constexpr double least_slope = 0.0005;
// After a descent that gains a smaller share of the sum no further one is made.
// [1; >= 0; M 2026-11 skull at 3 mm, pelvis]
constexpr double little_gain = 0.001;
// Gains are summed as integers of this many units, so that their order does not count. [units; > 0; D]
constexpr double gain_units = 1e6;
// The sum is infinite where a cell is next to flat; a gain counts as no more than this. [1; > 0; D]
constexpr double most_gain = 1e6;
// Room for the facets at a vertex that needs no allocation. [facets; > 0; B]
constexpr std::size_t usual_facets = 12;
// A vertex may slide if the normals of its facets have at least this cosine with their mean.
// [1; 0 to 1; M 2026-11 skull at 3 mm, pelvis]
constexpr double smooth_cosine = 0.9;
// After it slid they have at least this one. [1; 0 to 1; M 2026-11 skull at 3 mm, pelvis]
constexpr double turned_cosine = 0.8;

class Smoother {
  public:
    Smoother(const MovableMesh& mesh, const StructureField& field, std::uint32_t structures,
             const SmoothOptions& options)
        : mesh_(mesh.mesh),
          movable_(mesh),
          field_(field),
          structures_(structures),
          options_(options),
          min_sine_(std::sin(options.min_dihedral_degrees * std::numbers::pi / 180)),
          mover_(mesh.mesh, mesh.stars, options.max_radius_edge, min_sine_),
          vertices_(mesh.mesh.points.size()),
          moved_(mesh.mesh.points.size(), 0) {
        std::iota(vertices_.begin(), vertices_.end(), 0u);
    }

    SmoothStats run(RunContext& context) {
        bool all = true;
        for (int pass = 0; pass < options_.passes && !context.cancelled(); ++pass) {
            if (!smooth(all, context)) break;
            all = false;
        }
        worth_ = further_worth;
        all = true;
        for (int pass = 0; pass < options_.further_passes && !context.cancelled(); ++pass) {
            if (mean_ <= options_.max_mean || !smooth(all, context)) break;
            all = false;
        }
        return {moves_.inner + moves_.surface, moves_.surface};
    }

  private:
    // A pass over all vertices, or those beside which one moved in the last; false if there is none.
    bool smooth(bool all, RunContext& context) {
        const RatioSlopes slopes = ratio_slopes(mesh_, movable_.neighbors, movable_.fixed, context.threads);
        const std::vector<std::uint32_t> vertices =
            parallel_filter(vertices_, context.threads, [&](std::uint32_t v) {
                return slopes.steepness[v] >= worth_.look &&
                       mover_.star(v).size() <= StarRatios::most_cells && (all || one_moved_beside(v));
            });
        std::fill(moved_.begin(), moved_.end(), 0);
        gained_ = 0;
        mover_.for_each_apart(vertices, context.threads, [&](std::uint32_t v) {
            if (slopes.on_interface[v]) {
                slide_along_interface(v);
            } else if (move_inside(v)) {
                moves_.inner.fetch_add(1, std::memory_order_relaxed);
            }
        });
        if (slopes.cells > 0)
            mean_ =
                slopes.mean - static_cast<double>(gained_) / (gain_units * static_cast<double>(slopes.cells));
        return !vertices.empty();
    }

    // A facet of the interface at a vertex by its two other vertices, turned so that the normal leaves the
    // first region.
    using InterfaceFacet = std::array<std::uint32_t, 2>;

    bool one_moved_beside(std::uint32_t v) const {
        const auto star = mover_.star(v);
        return std::any_of(star.begin(), star.end(), [&](std::uint32_t c) {
            const Cell& cell = mesh_.cells[c];
            return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t u) { return moved_[u] != 0; });
        });
    }

    void slide_along_interface(std::uint32_t v) {
        Interface interface;
        if (find_interface(v, interface) && slide(v, interface))
            moves_.surface.fetch_add(1, std::memory_order_relaxed);
    }

    // The interface at a vertex: its facets, and the regions on both sides.
    struct Interface {
        std::vector<InterfaceFacet> facets;
        Region side = 0, other = 0;
    };

    // False where three or more regions meet.
    bool find_interface(std::uint32_t v, Interface& found) const {
        const auto star = mover_.star(v);
        found.side = found.other = mesh_.regions[star[0]];
        for (const std::uint32_t c : star) {
            if (mesh_.regions[c] == found.side) continue;
            if (found.other != found.side && mesh_.regions[c] != found.other) return false;
            found.other = mesh_.regions[c];
        }
        found.facets.reserve(usual_facets);
        for (const std::uint32_t c : star) {
            if (mesh_.regions[c] == found.side) add_facets_of(c, v, found.facets);
        }
        return true;
    }

    void add_facets_of(std::uint32_t c, std::uint32_t v, std::vector<InterfaceFacet>& facets) const {
        const Cell& cell = mesh_.cells[c];
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t n = movable_.neighbors[4 * std::size_t{c} + i];
            if (cell[i] == v || n == no_cell || mesh_.regions[n] == mesh_.regions[c]) continue;
            InterfaceFacet facet{};
            std::size_t found = 0;
            for (const std::uint32_t u : cell) {
                if (u != v && u != cell[i]) facet[found++] = u;
            }
            if (dot(normal(v, facet), mesh_.points[cell[i]] - mesh_.points[v]) > 0)
                std::swap(facet[0], facet[1]);
            facets.push_back(facet);
        }
    }

    Vec3 normal(std::uint32_t v, const InterfaceFacet& facet) const {
        return cross(mesh_.points[facet[0]] - mesh_.points[v], mesh_.points[facet[1]] - mesh_.points[v]);
    }

    bool within(std::uint32_t v, const std::vector<InterfaceFacet>& facets, Vec3 direction,
                double cosine) const {
        return std::all_of(facets.begin(), facets.end(), [&](const InterfaceFacet& facet) {
            const Vec3 n = normal(v, facet);
            return dot(n, direction) >= cosine * length(n);
        });
    }

    // A movement, in mean edges, and the sum with it.
    struct Step {
        Vec3 move;
        double sum;
    };

    // To a place nearby where the sum is less, or none: down the gradient, without its part along `normal`,
    // to where a parabola has its least. `before`: the sum without it.
    static Step better_place(const StarRatios& ratios, Vec3 normal, double& before) {
        Vec3 slope;
        Step at{{}, ratios.sum({}, slope)};
        before = at.sum;
        for (int n = 0; n < descents; ++n) {
            slope = slope - dot(slope, normal) * normal;
            const double steepness = length(slope);
            if (!(steepness * step_share > least_slope * before)) break;
            const Vec3 down = (-1 / steepness) * slope;
            const double stepped = ratios.sum(at.move + step_share * down);
            const double bend = stepped - at.sum + steepness * step_share;
            const double way = bend > 0
                                   ? std::min(0.5 * steepness * step_share * step_share / bend, longest_move)
                                   : longest_move;
            const Vec3 there = at.move + way * down;
            const double least = ratios.sum(there, slope);
            if (!(std::min(least, stepped) < at.sum)) break;
            if (stepped < least) return {at.move + step_share * down, stepped};
            const bool little = at.sum - least < little_gain * before;
            at = {there, least};
            if (little) break;
        }
        return at;
    }

    bool better(double after, double before) const { return after < (1 - worth_.gain) * before; }

    void moved(std::uint32_t v, double gain) {
        moved_[v] = 1;
        gained_.fetch_add(std::llround(gain_units * std::min(gain, most_gain)), std::memory_order_relaxed);
    }

    // Moves v by `move` if the cells there stay good.
    bool try_move(std::uint32_t v, const StarRatios& ratios, Vec3 move, Vec3 to) {
        switch (ratios.judge(move, options_.max_radius_edge, min_sine_)) {
            case StarRatios::Verdict::good:
                mesh_.points[v] = to;
                return true;
            case StarRatios::Verdict::bad:
                return false;
            default:
                return mover_.try_move(v, to);
        }
    }

    bool move_inside(std::uint32_t v) {
        const StarRatios ratios(mesh_, mover_.star(v), v);
        const Vec3 from = mesh_.points[v];
        double before = 0;
        Step step = better_place(ratios, {}, before);
        for (const double share : {1.0, 0.7, 0.45, 0.25}) {  // each of the one before
            if (share < 1) step = {share * step.move, ratios.sum(share * step.move)};
            if (!better(step.sum, before)) return false;
            if (!try_move(v, ratios, step.move, from + ratios.mean_edge() * step.move)) continue;
            moved(v, before - step.sum);
            return true;
        }
        return false;
    }

    // Along the interface, if that is smooth at v.
    bool slide(std::uint32_t v, const Interface& interface) {
        const std::vector<InterfaceFacet>& facets = interface.facets;
        Vec3 direction{};
        for (const InterfaceFacet& facet : facets) direction = direction + normal(v, facet);
        if (!(squared_length(direction) > 0)) return false;
        direction = (1 / length(direction)) * direction;
        if (!within(v, facets, direction, smooth_cosine)) return false;
        const StarRatios ratios(mesh_, mover_.star(v), v);
        double before = 0;
        const Step step = better_place(ratios, direction, before);
        if (!better(step.sum, before)) return false;
        const Vec3 from = mesh_.points[v];
        InterfaceProbe probe(field_, structures_);
        probe.focus_between(movable_.regions.members[interface.side],
                            movable_.regions.members[interface.other]);
        for (const double share : {1.0, 0.5}) {
            const auto onto = probe.project(from + share * ratios.mean_edge() * step.move,
                                            step_share * ratios.mean_edge(), 0.1 * options_.tolerance_mm);
            if (!onto) continue;
            const Vec3 move = (1 / ratios.mean_edge()) * (*onto - from);
            const double after = ratios.sum(move);
            if (!better(after, before) || !put(v, ratios, move, *onto, facets, direction, probe)) continue;
            moved(v, before - after);
            return true;
        }
        return false;
    }

    // Moves v to p unless a facet at it turns or leaves the field's interface, or a cell gets worse.
    bool put(std::uint32_t v, const StarRatios& ratios, Vec3 move, Vec3 p,
             const std::vector<InterfaceFacet>& facets, Vec3 direction, InterfaceProbe& probe) {
        const Vec3 from = mesh_.points[v];
        const auto deviation = [&](const InterfaceFacet& facet) {
            const Vec3 middle =
                (1.0 / 3.0) * (mesh_.points[v] + mesh_.points[facet[0]] + mesh_.points[facet[1]]);
            return probe.distance(middle);
        };
        if (!options_.slices.keeps(from, p) || !try_move(v, ratios, move, p)) return false;
        bool accepted = within(v, facets, direction, turned_cosine);
        for (std::size_t n = 0; accepted && n < facets.size(); ++n) {
            const double now = deviation(facets[n]);
            if (now <= options_.max_deviation_mm) continue;
            mesh_.points[v] = from;
            accepted = now <= deviation(facets[n]);
            mesh_.points[v] = p;
        }
        if (!accepted) mesh_.points[v] = from;
        return accepted;
    }

    TetMesh& mesh_;
    const MovableMesh movable_;
    const StructureField& field_;
    std::uint32_t structures_;
    SmoothOptions options_;
    double min_sine_;
    VertexMover mover_;
    Worth worth_ = usual_worth;
    std::vector<std::uint32_t> vertices_;  // all
    std::vector<std::uint8_t> moved_;      // by vertex, in the last pass
    double mean_ = 0;                      // ratio inside, after the last pass
    // The fall of the sum of the ratios in the last pass, in whole units: it is the same in any order.
    std::atomic<std::int64_t> gained_ = 0;
    struct {
        std::atomic<std::uint64_t> inner = 0, surface = 0;
    } moves_;  // in all passes
};

}  // namespace

SmoothStats smooth_vertices(const MovableMesh& mesh, const StructureField& field, std::uint32_t structures,
                            const SmoothOptions& options, RunContext& context) {
    assert(mesh.fixed.size() == mesh.mesh.points.size());
    assert(mesh.neighbors.size() == 4 * mesh.mesh.cells.size());
    return Smoother(mesh, field, structures, options).run(context);
}

}  // namespace anatomesh
