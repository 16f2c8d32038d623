#include "anatomesh/improve/improve.h"

#include <algorithm>
#include <cassert>

#include "anatomesh/improve/vertex_mover.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

class Improver {
  public:
    Improver(TetMesh& mesh, const std::vector<std::uint8_t>& fixed, const StructureField& field,
             std::uint32_t structures, const ImproveOptions& options)
        : mesh_(mesh),
          fixed_(fixed),
          options_(options),
          mover_(mesh, options.max_radius_edge),
          probe_(field, structures) {
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

    std::vector<std::uint32_t> bad_cells() const {
        std::vector<std::uint32_t> bad;
        for (std::uint32_t c = 0; c < mesh_.cells.size(); ++c) {
            if (mesh_.regions[c] != 0 && mover_.ratio(c) > options_.max_radius_edge) bad.push_back(c);
        }
        return bad;
    }

    void pull_onto_interface(std::uint32_t v) {
        const Vec3 from = mesh_.points[v];
        if (probe_.distance(from) <= options_.tolerance_mm) return;
        const double reach = 2.0 * mover_.shortest_edge(v);
        const auto target = probe_.project(from, reach, 0.1 * options_.tolerance_mm);
        if (!target) return;
        for (const double share : {1.0, 0.5, 0.25}) {
            if (mover_.try_move(v, from + share * (*target - from))) {
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
        const double start = mover_.worst_ratio(v), reach = mover_.shortest_edge(v);
        bool moved = false;
        for (double step = 0.3 * reach;
             step > 0.02 * reach && mover_.worst_ratio(v) > options_.max_radius_edge; step *= 0.5) {
            for (int direction = 0; direction < 6; ++direction) {
                const double d = direction % 2 ? -step : step;
                Vec3 to = mesh_.points[v] + Vec3{direction / 2 == 0 ? d : 0, direction / 2 == 1 ? d : 0,
                                                 direction / 2 == 2 ? d : 0};
                if (on_interface_[v]) {
                    const auto onto = probe_.project(to, 2 * step, 0.1 * options_.tolerance_mm);
                    if (onto) to = *onto;
                    if (!onto && probe_.distance(to) > options_.tolerance_mm) continue;
                }
                moved = mover_.try_better(v, to) || moved;
            }
        }
        return moved && mover_.worst_ratio(v) < start;
    }

    TetMesh& mesh_;
    const std::vector<std::uint8_t>& fixed_;
    ImproveOptions options_;
    VertexMover mover_;
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
