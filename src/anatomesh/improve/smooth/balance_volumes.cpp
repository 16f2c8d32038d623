#include "anatomesh/improve/smooth/balance_volumes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>

#include "anatomesh/improve/smooth/vertex_mover.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

// Signs of the structures that an interface bounds: +1 where they lie on its inner side, -1 on its outer
// side.
using Signs = std::vector<std::pair<std::uint32_t, double>>;

Signs signs_between(const RegionTable& table, Region inner, Region outer) {
    Signs signs;
    for (const std::uint32_t s : table.members[inner]) {
        if (!table.contains(outer, s)) signs.emplace_back(s, 1.0);
    }
    for (const std::uint32_t s : table.members[outer]) {
        if (!table.contains(inner, s)) signs.emplace_back(s, -1.0);
    }
    return signs;
}

// A facet between two regions, outward from the inner one (the one with the larger number).
struct Facet {
    Triangle triangle;
    std::uint32_t interface;  // index into the interfaces
    bool flat = false;        // in the plane of a flat end
};

struct Interface {
    Signs signs;
    double free_area = 0;  // thirds of its facets at free vertices, mm^2
    double offset = 0;     // how far it is to move outward, mm
};

// The displacement that moves all planes through a vertex by their offsets, as well as can be in the least
// squares weighed by area; exact for one plane, or up to three different ones.
class PlaneFit {
  public:
    void add(Vec3 normal, double area, double offset) {
        const std::array<double, 3> n{normal.x, normal.y, normal.z};
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) matrix_[i][j] += area * n[i] * n[j];
            right_[i] += area * offset * n[i];
        }
        area_ += area;
    }
    // A little stiffness keeps flat places from sliding along themselves.
    Vec3 solve() const {
        std::array<std::array<double, 3>, 3> a = matrix_;
        for (int i = 0; i < 3; ++i) a[i][i] += stiffness * area_;
        const Vec3 c0{a[0][0], a[1][0], a[2][0]}, c1{a[0][1], a[1][1], a[2][1]},
            c2{a[0][2], a[1][2], a[2][2]};
        const Vec3 b{right_[0], right_[1], right_[2]};
        const double determinant = dot(c0, cross(c1, c2));
        if (!(determinant > 0)) return {};
        return {dot(b, cross(c1, c2)) / determinant, dot(c0, cross(b, c2)) / determinant,
                dot(c0, cross(c1, b)) / determinant};
    }

  private:
    // Keeps the system regular where facets lie in few directions, as a share of their area. [1; > 0; M
    // 2026-11, set not recorded]
    static constexpr double stiffness = 0.01;
    std::array<std::array<double, 3>, 3> matrix_{};
    std::array<double, 3> right_{};
    double area_ = 0;
};

// A vertex on no flat end. [1; the largest index; D]
constexpr std::uint32_t no_end = 0xFFFFFFFFu;

class Balancer {
  public:
    Balancer(const MovableMesh& mesh, std::span<const double> targets, const BalanceOptions& options,
             int threads)
        : mesh_(mesh.mesh),
          regions_(mesh.regions),
          targets_(targets),
          options_(options),
          threads_(threads),
          mover_(mesh.mesh, mesh.stars, options.max_radius_edge,
                 std::sin(options.min_dihedral_degrees * std::numbers::pi / 180)),
          moved_(mesh.mesh.points.size()) {
        collect(mesh.neighbors, mesh.fixed);
        find_ends();
        put_onto_ends(mesh.stars);
    }

    BalanceStats run() {
        BalanceStats stats;
        std::vector<double> missing = missing_volumes();
        stats.worst_before = worst(missing);
        move_rounds(missing, stats);
        if (worst(missing) > options_.max_difference && has_ends()) {
            stats.ends_held = false;
            end_of_.assign(end_of_.size(), no_end);
            beside_end_ = end_of_;
            for (Facet& facet : facets_) facet.flat = false;
            move_rounds(missing, stats);
        }
        stats.worst_after = worst(missing);
        for (const Vec3& m : moved_) stats.largest_offset_mm = std::max(stats.largest_offset_mm, length(m));
        return stats;
    }

  private:
    void move_rounds(std::vector<double>& missing, BalanceStats& stats) {
        for (int round = 0; round < options_.rounds && worst(missing) > options_.tolerance; ++round) {
            find_offsets(missing);
            stats.moves += move_all();
            missing = missing_volumes();
        }
    }

    bool has_ends() const {
        return std::any_of(end_of_.begin(), end_of_.end(), [](std::uint32_t end) { return end != no_end; });
    }

    // The end in whose plane a point lies, the nearest of several, or no_end.
    std::uint32_t end_near(Vec3 p) const {
        std::uint32_t near = no_end;
        double least = options_.end_tolerance_mm;
        for (std::uint32_t n = 0; n < options_.ends.size(); ++n) {
            const double distance = std::abs(options_.ends[n].signed_distance(p));
            if (distance > least || (distance == least && near != no_end)) continue;
            least = distance;
            near = n;
        }
        return near;
    }

    // The facets that lie in an end, and their vertices.
    void find_ends() {
        end_of_.assign(mesh_.points.size(), no_end);
        beside_end_ = end_of_;
        if (options_.ends.empty()) return;
        std::vector<std::uint32_t> near(mesh_.points.size(), no_end);
        for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
            if (start_[v + 1] > start_[v]) near[v] = end_near(mesh_.points[v]);
        }
        const auto in_end = [&](const Triangle& t) {
            return near[t[0]] != no_end && near[t[0]] == near[t[1]] && near[t[0]] == near[t[2]];
        };
        for (Facet& facet : facets_) {
            facet.flat = in_end(facet.triangle);
            if (!facet.flat) continue;
            for (const std::uint32_t v : facet.triangle) end_of_[v] = near[v];
        }
        // What is beside an end is on it too, or stays on the inner side of its plane.
        std::vector<double> outward(mesh_.points.size(), 0);
        for (const Facet& facet : facets_) {
            if (!facet.flat) continue;
            const double up = dot(third_of_area(facet), options_.ends[near[facet.triangle[0]]].normal);
            for (const std::uint32_t v : facet.triangle) outward[v] = up > 0 ? 1 : -1;
        }
        beside_end_ = end_of_;
        outward_ = outward;
        for (const Facet& facet : facets_) {
            for (const std::uint32_t v : facet.triangle) {
                for (const std::uint32_t w : facet.triangle) {
                    if (beside_end_[w] != no_end) continue;
                    beside_end_[w] = end_of_[v];
                    outward_[w] = outward[v];
                }
            }
        }
        for (std::size_t v = 0; v < near.size(); ++v) {
            if (beside_end_[v] == near[v]) end_of_[v] = near[v];
        }
    }

    // p moved into the plane of the vertex's end, if it is on one, or if it is beside one and sticks out of
    // it.
    Vec3 onto_end(std::uint32_t v, Vec3 p) const {
        if (beside_end_[v] == no_end) return p;
        const Plane& end = options_.ends[beside_end_[v]];
        const double height = end.signed_distance(p);
        const double beyond = outward_[v] * height;
        const bool sticks_out = beyond > 0 && beyond < 5 * options_.end_tolerance_mm;
        return end_of_[v] != no_end || sticks_out ? p - height * end.normal : p;
    }

    // Rather a slightly smaller angle than a step in the end.
    void put_onto_ends(const VertexStars& stars) {
        if (!has_ends()) return;
        VertexMover smaller_angle(mesh_, stars, options_.max_radius_edge,
                                  std::sin(5 * std::numbers::pi / 180));
        for (const std::uint32_t v : free_) {
            const Vec3 to = onto_end(v, mesh_.points[v]);
            if (to != mesh_.points[v] && !mover_.try_move(v, to)) smaller_angle.try_move(v, to);
        }
    }

    // Facets between regions, by vertex; the vertices of such facets that are not fixed are free.
    void collect(std::span<const std::uint32_t> neighbors, const std::vector<std::uint8_t>& fixed) {
        std::map<std::pair<Region, Region>, std::uint32_t> numbers;
        for (const auto& [c, i, other] : region_facets(mesh_, neighbors, threads_)) {
            const Region inner = mesh_.regions[c],
                         outer = other == no_cell ? Region{0} : mesh_.regions[other];
            const auto [place, added] =
                numbers.try_emplace({inner, outer}, static_cast<std::uint32_t>(interfaces_.size()));
            if (added) interfaces_.push_back({signs_between(regions_, inner, outer), 0, 0});
            const auto& f = facet_vertices[i];
            all_.push_back(
                {{mesh_.cells[c][f[0]], mesh_.cells[c][f[1]], mesh_.cells[c][f[2]]}, place->second});
        }
        start_.assign(mesh_.points.size() + 1, 0);
        for (const Facet& facet : all_) {
            for (const std::uint32_t v : facet.triangle) ++start_[v + 1];
        }
        for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
            if (start_[v + 1] > 0 && !fixed[v]) free_.push_back(static_cast<std::uint32_t>(v));
            start_[v + 1] += start_[v];
        }
        facets_.resize(start_.back());
        std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
        for (const Facet& facet : all_) {
            for (const std::uint32_t v : facet.triangle) facets_[next[v]++] = facet;
        }
    }

    // A third of a facet's area, as a vector along its outward normal.
    Vec3 third_of_area(const Facet& facet) const {
        const auto& [a, b, c] = facet.triangle;
        return (1.0 / 6.0) * cross(mesh_.points[b] - mesh_.points[a], mesh_.points[c] - mesh_.points[a]);
    }

    // A structure's surface is closed: the volumes between its facets and one point add up to its own.
    std::vector<double> missing_volumes() const {
        std::vector<double> enclosed(interfaces_.size(), 0);
        const Vec3 apex = all_.empty() ? Vec3{} : mesh_.points[all_.front().triangle[0]];
        for (const Facet& facet : all_) {
            const auto& [a, b, c] = facet.triangle;
            enclosed[facet.interface] +=
                signed_volume(mesh_.points[a], mesh_.points[c], mesh_.points[b], apex);
        }
        std::vector<double> missing(targets_.begin(), targets_.end());
        for (std::size_t i = 0; i < interfaces_.size(); ++i) {
            for (const auto& [s, sign] : interfaces_[i].signs) missing[s] -= sign * enclosed[i];
        }
        return missing;
    }

    double worst(const std::vector<double>& missing) const {
        double worst = 0;
        for (std::size_t s = 0; s < missing.size(); ++s) {
            if (targets_[s] > 0) worst = std::max(worst, std::abs(missing[s]) / targets_[s]);
        }
        return worst;
    }

    // Gives every interface its offset. Conjugate gradients for sum over interfaces of area x signs x (signs
    // . numbers) = missing; (Hestenes and Stiefel, J. Res. Natl. Bur. Stand. 49, 1952).
    void find_offsets(const std::vector<double>& missing) {
        for (Interface& interface : interfaces_) interface.free_area = 0;
        for (const std::uint32_t v : free_) {
            for (std::uint32_t n = start_[v]; n < start_[v + 1]; ++n) {
                if (!facets_[n].flat)
                    interfaces_[facets_[n].interface].free_area += length(third_of_area(facets_[n]));
            }
        }
        const auto multiply = [&](const std::vector<double>& x) {
            std::vector<double> y(x.size(), 0);
            for (const Interface& interface : interfaces_) {
                double offset = 0;
                for (const auto& [s, sign] : interface.signs) offset += sign * x[s];
                for (const auto& [s, sign] : interface.signs) y[s] += interface.free_area * sign * offset;
            }
            return y;
        };
        const auto inner = [](const std::vector<double>& a, const std::vector<double>& b) {
            double sum = 0;
            for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
            return sum;
        };
        // Structures without a free facet cannot be met and would spoil the residual.
        std::vector<double> residual = missing;
        std::vector<std::uint8_t> has_area(missing.size(), 0);
        for (const Interface& interface : interfaces_) {
            for (const auto& [s, sign] : interface.signs)
                has_area[s] = interface.free_area > 0 || has_area[s];
        }
        for (std::size_t s = 0; s < residual.size(); ++s) {
            if (!has_area[s]) residual[s] = 0;
        }
        std::vector<double> x(missing.size(), 0), direction = residual;
        double square = inner(residual, residual);
        const double goal = 1e-10 * square;
        for (std::size_t step = 0; step < 4 * missing.size() + 10 && square > goal; ++step) {
            const std::vector<double> image = multiply(direction);
            const double curvature = inner(direction, image);
            if (!(curvature > 0)) break;
            const double length_of_step = square / curvature;
            for (std::size_t n = 0; n < x.size(); ++n) {
                x[n] += length_of_step * direction[n];
                residual[n] -= length_of_step * image[n];
            }
            const double next = inner(residual, residual);
            for (std::size_t n = 0; n < x.size(); ++n)
                direction[n] = residual[n] + next / square * direction[n];
            square = next;
        }
        for (Interface& interface : interfaces_) {
            interface.offset = 0;
            for (const auto& [s, sign] : interface.signs) interface.offset += sign * x[s];
        }
    }

    std::uint64_t move_all() {
        std::atomic<std::uint64_t> moves = 0;
        mover_.for_each_apart(free_, threads_, [&](std::uint32_t v) {
            PlaneFit fit;
            for (std::uint32_t n = start_[v]; n < start_[v + 1]; ++n) {
                const Vec3 vector = third_of_area(facets_[n]);
                const double area = length(vector);
                const double offset = facets_[n].flat ? 0 : interfaces_[facets_[n].interface].offset;
                if (area > 0) fit.add((1.0 / area) * vector, area, offset);
            }
            Vec3 total = moved_[v] + fit.solve();
            const double offset = length(total);
            if (offset > options_.max_offset_mm) total = (options_.max_offset_mm / offset) * total;
            const Vec3 from = mesh_.points[v], to = onto_end(v, from + (total - moved_[v]));
            if (to == from || !options_.slices.keeps(from, to) || !mover_.try_move(v, to)) return;
            moved_[v] = moved_[v] + (to - from);
            moves.fetch_add(1, std::memory_order_relaxed);
        });
        return moves;
    }

    TetMesh& mesh_;
    const RegionTable& regions_;
    std::span<const double> targets_;
    BalanceOptions options_;
    int threads_;
    VertexMover mover_;
    std::vector<std::uint32_t> start_;
    std::vector<Facet> all_, facets_;  // by vertex the second
    std::vector<Interface> interfaces_;
    std::vector<std::uint32_t> free_;
    // By vertex: the flat end that it lies on; the one that it lies on or shares a facet with.
    std::vector<std::uint32_t> end_of_, beside_end_;
    std::vector<double> outward_;  // 1 where the solid ends upwards there, -1 downwards
    std::vector<Vec3> moved_;
};

}  // namespace

BalanceStats balance_volumes(const MovableMesh& mesh, std::span<const double> target_mm3,
                             const BalanceOptions& options, int threads) {
    assert(mesh.fixed.size() == mesh.mesh.points.size());
    return Balancer(mesh, target_mm3, options, threads).run();
}

}  // namespace anatomesh
