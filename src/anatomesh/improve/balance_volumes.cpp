#include "anatomesh/improve/balance_volumes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>

#include "anatomesh/improve/vertex_mover.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/mesh/topology.h"

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
    static constexpr double stiffness = 0.01;
    std::array<std::array<double, 3>, 3> matrix_{};
    std::array<double, 3> right_{};
    double area_ = 0;
};

class Balancer {
  public:
    Balancer(TetMesh& mesh, const RegionTable& regions, const std::vector<std::uint8_t>& fixed,
             std::span<const double> targets, double max_radius_edge, const BalanceOptions& options, int threads)
        : mesh_(mesh),
          regions_(regions),
          targets_(targets),
          options_(options),
          mover_(mesh, max_radius_edge, std::sin(options.min_dihedral_degrees * std::numbers::pi / 180)),
          moved_(mesh.points.size()) {
        collect(fixed, threads);
    }

    BalanceStats run() {
        BalanceStats stats;
        std::vector<double> missing = missing_volumes();
        stats.worst_before = worst(missing);
        for (int round = 0; round < options_.rounds && worst(missing) > options_.tolerance; ++round) {
            find_offsets(missing);
            stats.moves += move_all();
            missing = missing_volumes();
        }
        stats.worst_after = worst(missing);
        for (const Vec3& m : moved_) stats.largest_offset_mm = std::max(stats.largest_offset_mm, length(m));
        return stats;
    }

  private:
    // Facets between regions, by vertex; the vertices of such facets that are not fixed are free.
    void collect(const std::vector<std::uint8_t>& fixed, int threads) {
        std::map<std::pair<Region, Region>, std::uint32_t> numbers;
        for (const auto& [c, i, other] : region_facets(mesh_, threads)) {
            const Region inner = mesh_.regions[c], outer = other == no_cell ? Region{0} : mesh_.regions[other];
            const auto [place, added] =
                numbers.try_emplace({inner, outer}, static_cast<std::uint32_t>(interfaces_.size()));
            if (added) interfaces_.push_back({signs_between(regions_, inner, outer), 0, 0});
            const auto& f = facet_vertices[i];
            all_.push_back({{mesh_.cells[c][f[0]], mesh_.cells[c][f[1]], mesh_.cells[c][f[2]]}, place->second});
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
            enclosed[facet.interface] += signed_volume(mesh_.points[a], mesh_.points[c], mesh_.points[b], apex);
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
        std::uint64_t moves = 0;
        for (const std::uint32_t v : free_) {
            PlaneFit fit;
            for (std::uint32_t n = start_[v]; n < start_[v + 1]; ++n) {
                const Vec3 vector = third_of_area(facets_[n]);
                const double area = length(vector);
                if (area > 0) fit.add((1.0 / area) * vector, area, interfaces_[facets_[n].interface].offset);
            }
            Vec3 total = moved_[v] + fit.solve();
            const double offset = length(total);
            if (offset > options_.max_offset_mm) total = (options_.max_offset_mm / offset) * total;
            const Vec3 step = total - moved_[v];
            if (squared_length(step) == 0 || !mover_.try_move(v, mesh_.points[v] + step)) continue;
            moved_[v] = total;
            ++moves;
        }
        return moves;
    }

    TetMesh& mesh_;
    const RegionTable& regions_;
    std::span<const double> targets_;
    BalanceOptions options_;
    VertexMover mover_;
    std::vector<std::uint32_t> start_;
    std::vector<Facet> all_, facets_;  // by vertex the second
    std::vector<Interface> interfaces_;
    std::vector<std::uint32_t> free_;
    std::vector<Vec3> moved_;
};

}  // namespace

BalanceStats balance_volumes(TetMesh& mesh, const RegionTable& regions,
                             const std::vector<std::uint8_t>& fixed, std::span<const double> target_mm3,
                             double max_radius_edge, const BalanceOptions& options, int threads) {
    assert(fixed.size() == mesh.points.size());
    return Balancer(mesh, regions, fixed, target_mm3, max_radius_edge, options, threads).run();
}

}  // namespace anatomesh
