#include "anatomesh/improve/balance_volumes.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "anatomesh/improve/vertex_mover.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/mesh/topology.h"

namespace anatomesh {

namespace {

// Signs of the structures that an interface bounds: +1 where they lie on its inner side, -1 on its outer side.
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

// The vertices that may move: those of exactly one interface, with its facets there.
struct FreeVertex {
    std::uint32_t vertex;
    Region inner, outer;
};

class Balancer {
  public:
    Balancer(TetMesh& mesh, const RegionTable& regions, const std::vector<std::uint8_t>& fixed,
             std::span<const double> targets, double max_radius_edge, const BalanceOptions& options)
        : mesh_(mesh), regions_(regions), targets_(targets), options_(options), mover_(mesh, max_radius_edge),
          moved_(mesh.points.size()) {
        collect(fixed);
    }

    BalanceStats run() {
        BalanceStats stats;
        std::vector<double> missing = missing_volumes();
        stats.worst_before = worst(missing);
        for (int round = 0; round < options_.rounds && worst(missing) > options_.tolerance; ++round) {
            const std::vector<double> numbers = solve(missing);
            stats.moves += move_all(numbers);
            missing = missing_volumes();
        }
        stats.worst_after = worst(missing);
        for (const Vec3& m : moved_) stats.largest_offset_mm = std::max(stats.largest_offset_mm, length(m));
        return stats;
    }

  private:
    // Facets between regions, by vertex; a vertex of one interface alone, and not fixed, is free.
    void collect(const std::vector<std::uint8_t>& fixed) {
        const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh_.cells, mesh_.points.size());
        std::vector<std::uint32_t> pair(mesh_.points.size(), 0);  // 0 none, 0xFFFFFFFF several
        start_.assign(mesh_.points.size() + 1, 0);
        const auto each_facet = [&](auto visit) {
            for (std::size_t c = 0; c < mesh_.cells.size(); ++c) {
                for (int i = 0; i < 4; ++i) {
                    const std::uint32_t n = neighbors[4 * c + i];
                    const Region outer = n == no_cell ? Region{0} : mesh_.regions[n];
                    if (mesh_.regions[c] > outer) visit(c, i, mesh_.regions[c], outer);
                }
            }
        };
        each_facet([&](std::size_t c, int i, Region inner, Region outer) {
            const std::uint32_t key = std::uint32_t{inner} << 16 | outer;
            for (const int k : facet_vertices[i]) {
                const std::uint32_t v = mesh_.cells[c][k];
                pair[v] = pair[v] == 0 || pair[v] == key ? key : 0xFFFFFFFFu;
                ++start_[v + 1];
            }
        });
        for (std::size_t v = 0; v < mesh_.points.size(); ++v) start_[v + 1] += start_[v];
        facets_.resize(start_.back());
        std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
        each_facet([&](std::size_t c, int i, Region, Region) {
            Triangle t{};
            for (int k = 0; k < 3; ++k) t[k] = mesh_.cells[c][facet_vertices[i][k]];
            for (const std::uint32_t v : t) facets_[next[v]++] = t;
        });
        for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
            if (fixed[v] || pair[v] == 0 || pair[v] == 0xFFFFFFFFu) continue;
            free_.push_back({v, static_cast<Region>(pair[v] >> 16), static_cast<Region>(pair[v] & 0xFFFF)});
        }
    }

    // A third of the areas at v, as an area vector and as a number.
    std::pair<Vec3, double> area_at(std::uint32_t v) const {
        Vec3 vector;
        double area = 0;
        for (std::uint32_t n = start_[v]; n < start_[v + 1]; ++n) {
            const Triangle& t = facets_[n];
            const Vec3 a = (1.0 / 6.0) * cross(mesh_.points[t[1]] - mesh_.points[t[0]], mesh_.points[t[2]] - mesh_.points[t[0]]);
            vector += a;
            area += length(a);
        }
        return {vector, area};
    }

    std::vector<double> missing_volumes() const {
        std::vector<double> missing(targets_.begin(), targets_.end());
        for (std::size_t c = 0; c < mesh_.cells.size(); ++c) {
            if (mesh_.regions[c] == 0) continue;
            const Cell& cell = mesh_.cells[c];
            const double volume = signed_volume(mesh_.points[cell[0]], mesh_.points[cell[1]], mesh_.points[cell[2]], mesh_.points[cell[3]]);
            for (const std::uint32_t s : regions_.members[mesh_.regions[c]]) missing[s] -= volume;
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

    // Conjugate gradients for sum over interfaces of area x signs x (signs . numbers) = missing; (Hestenes and Stiefel,
    // J. Res. Natl. Bur. Stand. 49, 1952).
    std::vector<double> solve(const std::vector<double>& missing) const {
        std::map<std::pair<Region, Region>, double> areas;
        for (const FreeVertex& f : free_) areas[{f.inner, f.outer}] += area_at(f.vertex).second;
        std::vector<std::pair<Signs, double>> interfaces;
        for (const auto& [sides, area] : areas) interfaces.emplace_back(signs_between(regions_, sides.first, sides.second), area);

        const auto multiply = [&](const std::vector<double>& x) {
            std::vector<double> y(x.size(), 0);
            for (const auto& [signs, area] : interfaces) {
                double offset = 0;
                for (const auto& [s, sign] : signs) offset += sign * x[s];
                for (const auto& [s, sign] : signs) y[s] += area * sign * offset;
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
        for (const auto& [signs, area] : interfaces) {
            for (const auto& [s, sign] : signs) has_area[s] = 1;
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
            for (std::size_t n = 0; n < x.size(); ++n) direction[n] = residual[n] + next / square * direction[n];
            square = next;
        }
        return x;
    }

    std::uint64_t move_all(const std::vector<double>& numbers) {
        std::uint64_t moves = 0;
        for (const FreeVertex& f : free_) {
            double offset = 0;
            for (const auto& [s, sign] : signs_between(regions_, f.inner, f.outer)) offset += sign * numbers[s];
            const auto [vector, area] = area_at(f.vertex);
            const double squared = squared_length(vector);
            // On a sharp ridge the normal says little: such a vertex stays.
            if (offset == 0 || !(squared > 0.1 * area * area)) continue;
            const Vec3 step = (offset * area / squared) * vector;
            const Vec3 total = moved_[f.vertex] + step;
            if (length(total) > options_.max_offset_mm) continue;
            if (!mover_.try_move(f.vertex, mesh_.points[f.vertex] + step)) continue;
            moved_[f.vertex] = total;
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
    std::vector<Triangle> facets_;  // by vertex
    std::vector<FreeVertex> free_;
    std::vector<Vec3> moved_;
};

}  // namespace

BalanceStats balance_volumes(TetMesh& mesh, const RegionTable& regions, const std::vector<std::uint8_t>& fixed,
                             std::span<const double> target_mm3, double max_radius_edge, const BalanceOptions& options) {
    assert(fixed.size() == mesh.points.size());
    return Balancer(mesh, regions, fixed, target_mm3, max_radius_edge, options).run();
}

}  // namespace anatomesh
