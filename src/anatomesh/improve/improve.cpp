#include "anatomesh/improve/improve.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

#include "anatomesh/cut/star.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/quality.h"
#include "anatomesh/mesh/topology.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

class Improver {
  public:
    Improver(TetMesh& mesh, const std::vector<std::uint8_t>& fixed, const StructureField& field,
             std::uint32_t structures, const ImproveOptions& options)
        : mesh_(mesh), fixed_(fixed), options_(options), stars_(mesh.cells, mesh.points.size()), probe_(field, structures) {
        find_interface_vertices();
    }

    ImproveStats run(RunContext& context) {
        stats_.above_bound_before = bad_cells().size();
        for (int round = 0; round < 3; ++round) {
            for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
                if (on_interface_[v] && !fixed_[v]) pull_onto_interface(v);
            }
        }
        for (int round = 0; round < options_.rounds && !context.cancelled(); ++round) {
            if (!smooth_bad_cells()) break;
        }
        stats_.above_bound_after = bad_cells().size();
        return stats_;
    }

  private:
    void find_interface_vertices() {
        on_interface_.assign(mesh_.points.size(), 0);
        std::vector<Region> first(mesh_.points.size(), 0xFFFF);
        for (std::size_t c = 0; c < mesh_.cells.size(); ++c) {
            for (const std::uint32_t v : mesh_.cells[c]) {
                if (first[v] == 0xFFFF) first[v] = mesh_.regions[c];
                if (first[v] != mesh_.regions[c]) on_interface_[v] = 1;
            }
        }
    }

    double ratio(std::uint32_t c) const {
        const Cell& cell = mesh_.cells[c];
        return radius_edge_ratio(mesh_.points[cell[0]], mesh_.points[cell[1]], mesh_.points[cell[2]], mesh_.points[cell[3]]);
    }

    std::vector<std::uint32_t> bad_cells() const {
        std::vector<std::uint32_t> bad;
        for (std::uint32_t c = 0; c < mesh_.cells.size(); ++c) {
            if (mesh_.regions[c] != 0 && ratio(c) > options_.max_radius_edge) bad.push_back(c);
        }
        return bad;
    }

    // The worst ratio of the cells inside at v.
    double worst_ratio(std::uint32_t v) const {
        double worst = 0;
        for (const std::uint32_t c : stars_.at(v)) {
            if (mesh_.regions[c] != 0) worst = std::max(worst, ratio(c));
        }
        return worst;
    }

    bool all_positive(std::uint32_t v) const {
        return std::all_of(stars_.at(v).begin(), stars_.at(v).end(), [&](std::uint32_t c) {
            const Cell& cell = mesh_.cells[c];
            return orient3d(mesh_.points[cell[0]], mesh_.points[cell[1]], mesh_.points[cell[2]], mesh_.points[cell[3]]) > 0;
        });
    }

    double shortest_edge_at(std::uint32_t v) const {
        double squared = INFINITY;
        for (const std::uint32_t c : stars_.at(v)) {
            for (const std::uint32_t u : mesh_.cells[c]) {
                if (u != v) squared = std::min(squared, squared_length(mesh_.points[u] - mesh_.points[v]));
            }
        }
        return std::sqrt(squared);
    }

    // Moves v to p unless a cell would turn over or the worst ratio get worse beyond the bound.
    bool try_move(std::uint32_t v, Vec3 p, double worst_before) {
        const Vec3 from = mesh_.points[v];
        mesh_.points[v] = p;
        if (worst_ratio(v) <= std::max(worst_before, options_.max_radius_edge) && all_positive(v)) return true;
        mesh_.points[v] = from;
        return false;
    }

    void pull_onto_interface(std::uint32_t v) {
        const Vec3 from = mesh_.points[v];
        if (probe_.distance(from) <= options_.tolerance_mm) return;
        const double reach = 2.0 * shortest_edge_at(v);
        const auto target = probe_.project(from, reach, 0.1 * options_.tolerance_mm);
        if (!target) return;
        const double before = worst_ratio(v);
        for (const double share : {1.0, 0.5, 0.25}) {
            if (try_move(v, from + share * (*target - from), before)) {
                ++stats_.vertices_onto_interface;
                return;
            }
        }
    }

    bool smooth_bad_cells() {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t c : bad_cells()) {
            for (const std::uint32_t v : mesh_.cells[c]) {
                if (!fixed_[v]) vertices.push_back(v);
            }
        }
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        std::uint64_t moved = 0;
        for (const std::uint32_t v : vertices) moved += smooth(v);
        stats_.vertices_smoothed += moved;
        return moved > 0;
    }

    // Compass search for the place where the worst ratio is least.
    bool smooth(std::uint32_t v) {
        const double start = worst_ratio(v);
        if (start <= options_.max_radius_edge) return false;
        double best = start;
        for (double step = 0.3 * shortest_edge_at(v); step > 0.02 * shortest_edge_at(v); step *= 0.5) {
            for (int direction = 0; direction < 6; ++direction) {
                const Vec3 from = mesh_.points[v];
                const double d = direction % 2 ? -step : step;
                Vec3 to = from + Vec3{direction / 2 == 0 ? d : 0, direction / 2 == 1 ? d : 0, direction / 2 == 2 ? d : 0};
                if (on_interface_[v]) {
                    const auto onto = probe_.project(to, 2 * step, 0.1 * options_.tolerance_mm);
                    if (onto) to = *onto;
                    if (!onto && probe_.distance(to) > options_.tolerance_mm) continue;
                }
                mesh_.points[v] = to;
                const double now = worst_ratio(v);
                if (now < best && all_positive(v)) {
                    best = now;
                } else {
                    mesh_.points[v] = from;
                }
            }
            if (best <= options_.max_radius_edge) break;
        }
        return best < start;
    }

    TetMesh& mesh_;
    const std::vector<std::uint8_t>& fixed_;
    ImproveOptions options_;
    VertexStars stars_;
    InterfaceProbe probe_;
    std::vector<std::uint8_t> on_interface_;
    ImproveStats stats_;
};

}  // namespace

ImproveStats improve(TetMesh& mesh, const std::vector<std::uint8_t>& fixed, const StructureField& field,
                     std::uint32_t structures, const ImproveOptions& options, RunContext& context) {
    assert(fixed.size() == mesh.points.size());
    return Improver(mesh, fixed, field, structures, options).run(context);
}

}  // namespace anatomesh
