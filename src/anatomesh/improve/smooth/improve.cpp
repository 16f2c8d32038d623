#include "anatomesh/improve/smooth/improve.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/parallel_filter.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/smooth/vertex_mover.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh {

namespace {

class Improver {
  public:
    Improver(TetMesh& mesh, const VertexStars& stars, const std::vector<std::uint8_t>& fixed,
             const StructureField& field, std::uint32_t structures, const RegionTable& regions,
             const ImproveOptions& options, int threads)
        : mesh_(mesh),
          fixed_(fixed),
          field_(field),
          structures_(structures),
          regions_(regions),
          options_(options),
          mover_(mesh, stars, options.max_radius_edge) {
        find_interface_vertices(threads);
    }

    ImproveStats run(RunContext& context) {
        std::vector<std::uint32_t> off;  // vertices that may be off the interface
        for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
            if (on_interface_[v] && !fixed_[v]) off.push_back(v);
        }
        std::vector<std::uint32_t> bad = bad_of(all_cells(), context.threads);
        stats_.above_bound_before = bad.size();
        pulled_.assign(mesh_.points.size(), 0);
        for (int round = 0; round < 3; ++round) {
            off = parallel_filter(off, context.threads, [&](std::uint32_t v) {
                InterfaceProbe probe(field_, structures_);
                look_at_surfaces_of(v, probe);
                return probe.distance(mesh_.points[v], options_.tolerance_mm) > options_.tolerance_mm;
            });
            pull_onto_interface(off, context.threads);
        }
        bad = bad_of(with_pulled(bad, context.threads), context.threads);
        for (int round = 0; round < options_.rounds && !context.cancelled(); ++round) {
            if (!smooth_cells(bad, context.threads)) break;
        }
        stats_.above_bound_after = bad.size();
        return stats_;
    }

  private:
    void find_interface_vertices(int threads) {
        on_interface_.assign(mesh_.points.size(), 0);
        parallel_for(mesh_.points.size(), 4096, threads, [&](std::size_t first, std::size_t last) {
            for (std::size_t v = first; v < last; ++v) {
                const auto star = mover_.star(static_cast<std::uint32_t>(v));
                on_interface_[v] = std::any_of(star.begin(), star.end(), [&](std::uint32_t c) {
                    return mesh_.regions[c] != mesh_.regions[star[0]];
                });
            }
        });
    }

    // All that pass through the vertex.
    void look_at_surfaces_of(std::uint32_t v, InterfaceProbe& probe) const {
        if (structures_ == 1) return;
        const std::vector<std::uint32_t>& first = regions_.members[mesh_.regions[mover_.star(v)[0]]];
        std::vector<std::uint32_t> all = first, common = first, joined;
        for (const std::uint32_t c : mover_.star(v)) {
            const std::vector<std::uint32_t>& here = regions_.members[mesh_.regions[c]];
            joined.clear();
            std::set_union(all.begin(), all.end(), here.begin(), here.end(), std::back_inserter(joined));
            all.swap(joined);
            joined.clear();
            std::set_intersection(common.begin(), common.end(), here.begin(), here.end(),
                                  std::back_inserter(joined));
            common.swap(joined);
        }
        probe.focus_between(all, common);
    }

    std::vector<std::uint32_t> all_cells() const {
        std::vector<std::uint32_t> all(mesh_.cells.size());
        std::iota(all.begin(), all.end(), 0u);
        return all;
    }

    // The cells inside with a ratio above the bound.
    std::vector<std::uint32_t> bad_of(const std::vector<std::uint32_t>& cells, int threads) const {
        const double bound = options_.max_radius_edge * options_.max_radius_edge;
        return parallel_filter(cells, threads, [&](std::uint32_t c) {
            return mesh_.regions[c] != 0 && mover_.squared_ratio(c) > bound;
        });
    }

    // `cells`, which rise, and those with a vertex that was pulled: all others are as they were.
    std::vector<std::uint32_t> with_pulled(const std::vector<std::uint32_t>& cells, int threads) const {
        const std::vector<std::uint32_t> changed =
            parallel_filter(all_cells(), threads, [&](std::uint32_t c) {
                const Cell& cell = mesh_.cells[c];
                return (pulled_[cell[0]] | pulled_[cell[1]] | pulled_[cell[2]] | pulled_[cell[3]]) != 0;
            });
        std::vector<std::uint32_t> all;
        std::set_union(cells.begin(), cells.end(), changed.begin(), changed.end(), std::back_inserter(all));
        return all;
    }

    // `off` rises. Where to is found for all before one moves.
    void pull_onto_interface(const std::vector<std::uint32_t>& off, int threads) {
        std::vector<std::optional<Vec3>> targets(off.size());
        parallel_for(off.size(), 256, threads, [&](std::size_t first, std::size_t last) {
            InterfaceProbe probe(field_, structures_);
            for (std::size_t n = first; n < last; ++n) {
                look_at_surfaces_of(off[n], probe);
                targets[n] = probe.project(mesh_.points[off[n]], 2.0 * mover_.shortest_edge(off[n]),
                                           0.1 * options_.tolerance_mm);
            }
        });
        std::atomic<std::uint64_t> pulled = 0;
        mover_.for_each_apart(off, threads, [&](std::uint32_t v) {
            const auto n = std::lower_bound(off.begin(), off.end(), v) - off.begin();
            const auto& target = targets[static_cast<std::size_t>(n)];
            if (!target || !pull(v, *target)) return;
            pulled_[v] = 1;
            pulled.fetch_add(1, std::memory_order_relaxed);
        });
        stats_.vertices_onto_interface += pulled;
    }

    bool pull(std::uint32_t v, Vec3 target) {
        const Vec3 from = mesh_.points[v];
        for (const double share : {1.0, 0.5, 0.25}) {
            if (mover_.try_move(v, from + share * (target - from))) return true;
        }
        return false;
    }

    // Moves vertices of the bad cells; they become those bad afterwards. Says whether one got better.
    bool smooth_cells(std::vector<std::uint32_t>& bad, int threads) {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t c : bad) {
            for (const std::uint32_t v : mesh_.cells[c]) {
                if (!fixed_[v]) vertices.push_back(v);
            }
        }
        sort_distinct(vertices, mesh_.points.size());
        std::atomic<std::uint64_t> moved = 0;
        mover_.for_each_in_order(vertices, threads, [&](std::uint32_t v) {
            if (smooth(v)) moved.fetch_add(1, std::memory_order_relaxed);
        });
        for (const std::uint32_t v : vertices) {
            const auto star = mover_.star(v);
            bad.insert(bad.end(), star.begin(), star.end());
        }
        sort_distinct(bad, mesh_.cells.size());
        bad = bad_of(bad, threads);
        stats_.vertices_smoothed += moved;
        return moved > 0;
    }

    // Compass search for the place where the worst ratio is least.
    bool smooth(std::uint32_t v) {
        InterfaceProbe probe(field_, structures_);
        VertexMover::Shape worst = mover_.shape(v);
        const double start = worst.squared_ratio, reach = mover_.shortest_edge(v);
        bool moved = false;
        for (double step = 0.3 * reach;
             step > 0.02 * reach && std::sqrt(worst.squared_ratio) > options_.max_radius_edge; step *= 0.5) {
            for (int direction = 0; direction < 6; ++direction) {
                const double d = direction % 2 ? -step : step;
                Vec3 to = mesh_.points[v] + Vec3{direction / 2 == 0 ? d : 0, direction / 2 == 1 ? d : 0,
                                                 direction / 2 == 2 ? d : 0};
                if (on_interface_[v]) {
                    look_at_surfaces_of(v, probe);
                    const auto onto = probe.project(to, 2 * step, 0.1 * options_.tolerance_mm);
                    if (onto) to = *onto;
                    if (!onto && probe.distance(to) > options_.tolerance_mm) continue;
                }
                moved = mover_.try_better(v, to, worst) || moved;
            }
        }
        return moved && std::sqrt(worst.squared_ratio) < std::sqrt(start);
    }

    TetMesh& mesh_;
    const std::vector<std::uint8_t>& fixed_;
    const StructureField& field_;
    std::uint32_t structures_;
    const RegionTable& regions_;
    ImproveOptions options_;
    VertexMover mover_;
    std::vector<std::uint8_t> on_interface_, pulled_;  // by vertex
    ImproveStats stats_;
};

}  // namespace

ImproveStats improve(TetMesh& mesh, const VertexStars& stars, const std::vector<std::uint8_t>& fixed,
                     const StructureField& field, std::uint32_t structures, const RegionTable& regions,
                     const ImproveOptions& options, RunContext& context) {
    assert(fixed.size() == mesh.points.size());
    return Improver(mesh, stars, fixed, field, structures, regions, options, context.threads).run(context);
}

}  // namespace anatomesh
