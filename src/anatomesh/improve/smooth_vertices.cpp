#include "anatomesh/improve/smooth_vertices.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <numbers>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh/improve/chosen_of.h"
#include "anatomesh/improve/vertex_mover.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

constexpr double step_share = 0.1;     // of the mean edge at the vertex, that is tried first
constexpr double longest_move = 3;     // in steps
constexpr int descents = 2;            // a vertex, in a pass
constexpr double least_gain = 0.005;   // of the sum, for which a vertex is moved
constexpr double smooth_cosine = 0.9;  // of the facets' normals with their mean, at a vertex that may slide
constexpr double turned_cosine = 0.8;  // the same after it slid

// The cells inside round a vertex, each by its facet opposite to the vertex. The circumcentre of such a cell
// lies on the axis of the facet, t above the facet's own, and its squared radius is t^2 more than the
// facet's.
class RatioSum {
  public:
    static constexpr std::size_t most_cells = 96;

    // Requires: at most most_cells cells in the star.
    RatioSum(const TetMesh& mesh, std::span<const std::uint32_t> star, std::uint32_t v) {
        static constexpr std::uint8_t others[4][3] = {{1, 2, 3}, {0, 3, 2}, {3, 0, 1}, {2, 1, 0}};
        double length_sum = 0;
        for (const std::uint32_t c : star) {
            if (mesh.regions[c] == 0) continue;
            const Cell& cell = mesh.cells[c];
            const auto k = static_cast<std::size_t>(std::find(cell.begin(), cell.end(), v) - cell.begin());
            facets_[count_++] = facet(mesh.points[cell[others[k][0]]], mesh.points[cell[others[k][1]]],
                                      mesh.points[cell[others[k][2]]]);
            length_sum += length(facets_[count_ - 1].p - mesh.points[v]);
        }
        mean_edge_ = count_ == 0 ? 0 : length_sum / static_cast<double>(count_);
    }

    double mean_edge() const { return mean_edge_; }

    // With the vertex at x; a number not less than `enough` where it is not less, or where a cell is not
    // positive.
    double at(Vec3 x, double enough) const {
        double sum = 0;
        for (std::size_t n = 0; n < count_; ++n) {
            const Facet& f = facets_[n];
            const Vec3 d = x - f.center;
            const double height = dot(f.normal, d);
            if (!(height > 0)) return INFINITY;
            const double t = (squared_length(d) - f.squared_radius) / (2 * height);
            const double shortest = std::min(std::min(squared_length(x - f.p), squared_length(x - f.q)),
                                             std::min(squared_length(x - f.r), f.squared_shortest));
            sum += std::sqrt((f.squared_radius + t * t) / shortest);
            if (sum >= enough) return sum;
        }
        return sum;
    }

    // Of the sum, with the vertex at x, where all cells are positive. A circumcentre moves along the axis by
    // the component of x's movement towards it, over the height.
    Vec3 gradient(Vec3 x) const {
        Vec3 sum{};
        for (std::size_t n = 0; n < count_; ++n) {
            const Facet& f = facets_[n];
            const Vec3 d = x - f.center;
            const double height = dot(f.normal, d), t = (squared_length(d) - f.squared_radius) / (2 * height);
            const double radius = std::sqrt(f.squared_radius + t * t);
            const Vec3 from_center = d - t * f.normal;
            Vec3 nearest{};
            double shortest = f.squared_shortest;
            for (const Vec3 q : {f.p, f.q, f.r}) {
                if (squared_length(x - q) < shortest) nearest = x - q, shortest = squared_length(nearest);
            }
            const double edge = std::sqrt(shortest);
            sum = sum + (t / (radius * height * edge)) * from_center - (radius / (edge * shortest)) * nearest;
        }
        return sum;
    }

  private:
    struct Facet {
        Vec3 p, q, r, center, normal;
        double squared_radius, squared_shortest;
    };

    static Facet facet(Vec3 p, Vec3 q, Vec3 r) {
        const Vec3 a = q - p, b = r - p, n = cross(a, b);
        const double a2 = squared_length(a), b2 = squared_length(b), n2 = squared_length(n);
        const Vec3 center = (0.5 / n2) * (a2 * cross(b, n) + b2 * cross(n, a));
        return {p,
                q,
                r,
                p + center,
                (-1 / std::sqrt(n2)) * n,
                squared_length(center),
                std::min({a2, b2, squared_length(r - q)})};
    }

    std::array<Facet, most_cells> facets_;
    std::size_t count_ = 0;
    double mean_edge_ = 0;
};

class Smoother {
  public:
    Smoother(TetMesh& mesh, std::span<const std::uint32_t> neighbors, const std::vector<std::uint8_t>& fixed,
             const StructureField& field, std::uint32_t structures, const SmoothOptions& options, int threads)
        : mesh_(mesh),
          neighbors_(neighbors),
          fixed_(fixed),
          field_(field),
          structures_(structures),
          options_(options),
          mover_(mesh, options.max_radius_edge,
                 std::sin(options.min_dihedral_degrees * std::numbers::pi / 180), threads),
          moved_(mesh.points.size(), 0) {}

    SmoothStats run(RunContext& context) {
        std::vector<std::uint32_t> all(mesh_.points.size());
        for (std::uint32_t v = 0; v < all.size(); ++v) all[v] = v;
        std::vector<std::uint32_t> vertices =
            chosen_of(all, context.threads, [&](std::uint32_t v) { return !fixed_[v] && touches_inside(v); });
        for (int pass = 0; pass < options_.passes && !vertices.empty() && !context.cancelled(); ++pass) {
            for (const std::uint32_t v : vertices) moved_[v] = 0;
            mover_.for_each_apart(vertices, context.threads, [&](std::uint32_t v) { smooth(v); });
            vertices =
                chosen_of(vertices, context.threads, [&](std::uint32_t v) { return one_moved_beside(v); });
        }
        return {inner_moves_ + surface_moves_, surface_moves_};
    }

  private:
    // A facet of the interface at a vertex by its two other vertices, turned so that the normal leaves the
    // first region.
    using InterfaceFacet = std::array<std::uint32_t, 2>;

    bool touches_inside(std::uint32_t v) const {
        const auto star = mover_.star(v);
        return std::any_of(star.begin(), star.end(), [&](std::uint32_t c) { return mesh_.regions[c] != 0; });
    }

    bool one_moved_beside(std::uint32_t v) const {
        const auto star = mover_.star(v);
        return std::any_of(star.begin(), star.end(), [&](std::uint32_t c) {
            const Cell& cell = mesh_.cells[c];
            return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t u) { return moved_[u] != 0; });
        });
    }

    void smooth(std::uint32_t v) {
        std::vector<InterfaceFacet> facets;
        if (mover_.star(v).size() > RatioSum::most_cells || !find_interface(v, facets)) return;
        if (facets.empty()) {
            if (move_inside(v)) inner_moves_.fetch_add(1, std::memory_order_relaxed);
        } else if (slide(v, facets)) {
            surface_moves_.fetch_add(1, std::memory_order_relaxed);
        }
    }

    // The facets of the interface at v; false where three or more regions meet.
    bool find_interface(std::uint32_t v, std::vector<InterfaceFacet>& facets) const {
        const auto star = mover_.star(v);
        const Region side = mesh_.regions[star[0]];
        Region other = side;
        for (const std::uint32_t c : star) {
            if (mesh_.regions[c] == side) continue;
            if (other != side && mesh_.regions[c] != other) return false;
            other = mesh_.regions[c];
        }
        if (other == side) return true;
        for (const std::uint32_t c : star) {
            if (mesh_.regions[c] == side) add_facets_of(c, v, facets);
        }
        return true;
    }

    void add_facets_of(std::uint32_t c, std::uint32_t v, std::vector<InterfaceFacet>& facets) const {
        const Cell& cell = mesh_.cells[c];
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t n = neighbors_[4 * std::size_t{c} + i];
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

    // A place near `from` where the sum is less, or `from`: down the gradient, without its part along
    // `normal`, to where a parabola has its least.
    static Vec3 better_place(const RatioSum& ratios, Vec3 from, double before, Vec3 normal) {
        const double step = step_share * ratios.mean_edge();
        for (int n = 0; n < descents; ++n) {
            Vec3 slope = ratios.gradient(from);
            slope = slope - dot(slope, normal) * normal;
            const double steepness = length(slope);
            if (!(steepness * step > 0.1 * least_gain * before)) break;
            const Vec3 down = (-1 / steepness) * slope;
            const double stepped = ratios.at(from + step * down, INFINITY);
            const double bend = stepped - before + steepness * step;
            double best = stepped < before ? step : 0, least = std::min(stepped, before);
            const double way = bend > 0 ? std::min(0.5 * steepness * step * step / bend, longest_move * step)
                                        : longest_move * step;
            const double there = ratios.at(from + way * down, least);
            if (there < least) least = there, best = way;
            if (best == 0) break;
            from = from + best * down;
            before = least;
        }
        return from;
    }

    bool move_inside(std::uint32_t v) {
        const RatioSum ratios(mesh_, mover_.star(v), v);
        const Vec3 from = mesh_.points[v];
        const double before = ratios.at(from, INFINITY);
        const Vec3 to = better_place(ratios, from, before, {});
        for (const double share : {1.0, 0.5}) {
            const Vec3 at = from + share * (to - from);
            if (!(ratios.at(at, before) < (1 - least_gain) * before)) return false;
            if (!mover_.try_move(v, at)) continue;
            moved_[v] = 1;
            return true;
        }
        return false;
    }

    // Along the interface, if that is smooth at v.
    bool slide(std::uint32_t v, const std::vector<InterfaceFacet>& facets) {
        Vec3 direction{};
        for (const InterfaceFacet& facet : facets) direction = direction + normal(v, facet);
        if (!(squared_length(direction) > 0)) return false;
        direction = (1 / length(direction)) * direction;
        if (!within(v, facets, direction, smooth_cosine)) return false;
        const RatioSum ratios(mesh_, mover_.star(v), v);
        const Vec3 from = mesh_.points[v];
        const double before = ratios.at(from, INFINITY);
        const Vec3 to = better_place(ratios, from, before, direction);
        if (!(ratios.at(to, before) < (1 - least_gain) * before)) return false;
        InterfaceProbe probe(field_, structures_);
        for (const double share : {1.0, 0.5}) {
            const auto onto = probe.project(from + share * (to - from), step_share * ratios.mean_edge(),
                                            0.1 * options_.tolerance_mm);
            if (!onto || !(ratios.at(*onto, before) < (1 - least_gain) * before)) continue;
            if (!put(v, *onto, facets, direction, probe)) continue;
            moved_[v] = 1;
            return true;
        }
        return false;
    }

    // Moves v to p unless a facet at it turns or leaves the field's interface, or a cell gets worse.
    bool put(std::uint32_t v, Vec3 p, const std::vector<InterfaceFacet>& facets, Vec3 direction,
             InterfaceProbe& probe) {
        const Vec3 from = mesh_.points[v];
        const auto deviation = [&](const InterfaceFacet& facet) {
            const Vec3 middle =
                (1.0 / 3.0) * (mesh_.points[v] + mesh_.points[facet[0]] + mesh_.points[facet[1]]);
            return probe.distance(middle);
        };
        if (!mover_.try_move(v, p)) return false;
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
    std::span<const std::uint32_t> neighbors_;
    const std::vector<std::uint8_t>& fixed_;
    const StructureField& field_;
    std::uint32_t structures_;
    SmoothOptions options_;
    VertexMover mover_;
    std::vector<std::uint8_t> moved_;
    std::atomic<std::uint64_t> inner_moves_ = 0, surface_moves_ = 0;
};

}  // namespace

SmoothStats smooth_vertices(TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                            const std::vector<std::uint8_t>& fixed, const StructureField& field,
                            std::uint32_t structures, const SmoothOptions& options, RunContext& context) {
    assert(fixed.size() == mesh.points.size());
    assert(neighbors.size() == 4 * mesh.cells.size());
    return Smoother(mesh, neighbors, fixed, field, structures, options, context.threads).run(context);
}

}  // namespace anatomesh
