#include "anatomesh/cut/relabel.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/cut/label_descent.h"
#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/shape/quality.h"

namespace anatomesh {

namespace {

constexpr std::size_t stars_ahead = 2;  // Stars are fetched into the cache so many before. [stars; >= 0; B]
constexpr int most_mends =
    8;  // Passes go over the cells that are wrong in a slice's plane. [passes; >= 1; B]
// Moves of variable depth go over lost subsegments so often. [passes; >= 0; B]
constexpr int most_passes_in_depth = 4;
// A cell is nearly flat with six volumes below this. [cubes of the longest edge; 0 to 1e-3; M 2026-11, set not recorded]
constexpr double flat_share = 1e-6;

bool nearly_flat(const std::vector<Vec3>& points, const Cell& cell) {
    double longest = 0;
    for (const auto& [i, j] : cell_edges)
        longest = std::max(longest, squared_length(points[cell[i]] - points[cell[j]]));
    const double volume = signed_volume(points[cell[0]], points[cell[1]], points[cell[2]], points[cell[3]]);
    return 6 * volume < flat_share * longest * std::sqrt(longest);
}

// A vertex with a share in the weighted sum.
struct Suspect {
    std::uint32_t vertex;
    int lost_subsegments;
    bool nonmanifold, lost;
};

// Those of `look`, or of all vertices where it is empty; in their order.
std::vector<Suspect> find_suspects(const RelabelledMesh& mesh, const std::vector<std::uint32_t>& look,
                                   int threads) {
    const VertexStars& stars = mesh.stars;
    const std::size_t count = look.empty() ? mesh.points.size() : look.size();
    // Only vertices of an interface, or of a contour, can have one.
    const auto can_be = [&](std::uint32_t v) {
        const auto star = stars.at(v);
        return std::any_of(star.begin(), star.end(),
                           [&](std::uint32_t c) { return mesh.regions[c] != mesh.regions[star[0]]; }) ||
               !mesh.owners.at(v).empty() || !mesh.owners.subsegments_at(v).empty();
    };
    // Few pieces: an analyzer has scratch space for all cells.
    const std::size_t grain = std::max<std::size_t>(4096, count / 8 + 1);
    return parallel_collect<Suspect>(
        count, grain, threads, [&](std::size_t first, std::size_t last, std::vector<Suspect>& found) {
            StarAnalyzer analyzer(mesh.cells, mesh.neighbors, stars, mesh.regions, mesh.registry.table(),
                                  mesh.owners);
            std::vector<std::uint32_t> lost, vertices;
            for (std::size_t n = first; n < last; ++n) {
                const std::uint32_t v = look.empty() ? static_cast<std::uint32_t>(n) : look[n];
                if (!look.empty() || can_be(v)) vertices.push_back(v);
            }
            for (std::size_t n = 0; n < vertices.size(); ++n) {
                const std::uint32_t v = vertices[n];
                if (n + stars_ahead < vertices.size()) {
                    for (const std::uint32_t c : stars.at(vertices[n + stars_ahead])) {
                        __builtin_prefetch(&mesh.cells[c]);
                        __builtin_prefetch(&mesh.neighbors[c]);
                    }
                }
                Suspect suspect{v, analyzer.lost_subsegment_count(v), analyzer.singularity_count(v) > 0,
                                false};
                if (!suspect.nonmanifold && suspect.lost_subsegments == 0) continue;
                analyzer.lost_structures(v, lost);
                suspect.lost = suspect.nonmanifold && !lost.empty();
                found.push_back(suspect);
            }
        });
}

std::vector<std::uint32_t> nearly_flat_cells(const std::vector<Vec3>& points, const std::vector<Cell>& cells,
                                             int threads) {
    return parallel_collect<std::uint32_t>(
        cells.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            for (std::size_t c = first; c < last; ++c) {
                if (c + cells_ahead < last) prefetch_points(points, cells[c + cells_ahead]);
                if (nearly_flat(points, cells[c])) found.push_back(static_cast<std::uint32_t>(c));
            }
        });
}

// Those of the vertices, rising.
std::vector<std::uint32_t> unresolved(LabelSingularities& singularities,
                                      std::vector<std::uint32_t> vertices) {
    sort_distinct(vertices);
    std::erase_if(vertices, [&](std::uint32_t v) { return singularities.total(v) == 0; });
    return vertices;
}

// Those at the vertices of `look`, or of all where it is empty, that are other than what is drawn where a
// plane cuts them; rising.
std::vector<std::uint32_t> wrong_cells(const RelabelledMesh& mesh, const SlicePlanes& slices,
                                       const std::vector<std::uint32_t>& look, int threads) {
    std::vector<std::uint32_t> among;
    for (const std::uint32_t v : look)
        among.insert(among.end(), mesh.stars.at(v).begin(), mesh.stars.at(v).end());
    std::sort(among.begin(), among.end());
    among.erase(std::unique(among.begin(), among.end()), among.end());
    const auto on_interface = [&](std::uint32_t c) {
        return std::any_of(mesh.neighbors[c].begin(), mesh.neighbors[c].end(), [&](std::uint32_t n) {
            return n != no_cell && mesh.regions[n] != mesh.regions[c];
        });
    };
    return parallel_collect<std::uint32_t>(
        look.empty() ? mesh.cells.size() : among.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            DrawnSections sections(mesh.points, mesh.cells, mesh.neighbors, mesh.regions,
                                   mesh.registry.table(), slices);
            for (std::size_t n = first; n < last; ++n) {
                const std::uint32_t c = look.empty() ? static_cast<std::uint32_t>(n) : among[n];
                if (on_interface(c) && sections.wanted(c)) found.push_back(c);
            }
        });
}

// Makes moves at the vertices of `queue`, round by round, until none is left and all kinds are allowed. `queue` is
// left with the vertices that have a share in the sum.
void work_through(LabelDescent& descent, bool one_structure, std::vector<std::uint32_t>& queue,
                  RelabelStats& stats) {
    AllowedMoves& allowed = descent.allowed();
    while (!queue.empty()) {
        std::vector<std::uint32_t> next;
        bool moved = false;
        for (const std::uint32_t v : queue) {
            if (descent.singularities().total(v) == 0) continue;
            const std::size_t count = descent.improve(v, next);
            stats.cells_moved += count;
            moved = moved || count > 0;
            next.push_back(v);
        }
        queue = unresolved(descent.singularities(), std::move(next));
        if (!moved && !allowed.losses) {
            allowed.losses = true;
        } else if (!moved) {
            if (allowed.spikes && allowed.spoiling) break;
            allowed.spikes = allowed.spikes || allowed.spoiling || one_structure;
            allowed.spoiling = true;
        }
    }
}

// Brings subsegments back by moves of variable depth, then works through what these touched, a few times.
void work_in_depth(LabelDescent& descent, bool one_structure, std::vector<std::uint32_t>& queue,
                   RelabelStats& stats) {
    for (int pass = 0; pass < most_passes_in_depth && !queue.empty(); ++pass) {
        std::vector<std::uint32_t> next;
        for (const std::uint32_t v : queue) {
            if (descent.singularities().lost_subsegments(v) > 0)
                stats.cells_moved += descent.improve_in_depth(v, next);
        }
        if (next.empty()) break;
        next.insert(next.end(), queue.begin(), queue.end());
        queue = unresolved(descent.singularities(), std::move(next));
        work_through(descent, one_structure, queue, stats);
    }
}

// Relabels cells that are wrong where a plane cuts them to what is drawn there, pass by pass until none changes.
void mend_sections(LabelDescent& descent, const std::vector<std::uint32_t>& wrong,
                   std::vector<std::uint32_t>& queue, RelabelStats& stats) {
    std::vector<std::uint32_t> touched = std::move(queue);
    for (int pass = 0; pass < most_mends; ++pass) {
        const std::uint64_t before = stats.cells_mended;
        for (const std::uint32_t c : wrong) stats.cells_mended += descent.mend(c, touched);
        if (stats.cells_mended == before) break;
    }
    queue = unresolved(descent.singularities(), std::move(touched));
}

// `queue` receives the vertices.
void count_before(const std::vector<Suspect>& suspects, std::vector<std::uint32_t>& queue,
                  RelabelStats& stats) {
    for (const Suspect& suspect : suspects) {
        queue.push_back(suspect.vertex);
        stats.nonmanifold_before += suspect.nonmanifold;
        stats.lost_before += suspect.lost;
        stats.lost_subsegments_before += static_cast<std::uint64_t>(suspect.lost_subsegments);
    }
    stats.lost_subsegments_before /= 2;
}

// `nonmanifold` receives the vertices of `queue` that are.
void count_after(LabelDescent& descent, const std::vector<std::uint32_t>& queue,
                 std::vector<std::uint32_t>& nonmanifold, RelabelStats& stats) {
    nonmanifold.clear();
    for (const std::uint32_t v : queue) {
        if (descent.singularities().singularity_count(v) > 0) nonmanifold.push_back(v);
        stats.lost_subsegments_after +=
            static_cast<std::uint64_t>(descent.singularities().lost_subsegments(v));
    }
    stats.lost_subsegments_after /= 2;
    stats.nonmanifold_after = nonmanifold.size();
    for (const std::uint32_t v : nonmanifold) stats.lost_after += descent.is_lost(v);
}

}  // namespace

RelabelStats relabel(const RelabelledMesh& mesh, const RelabelOptions& options,
                     std::vector<std::uint32_t>& nonmanifold, const std::vector<std::uint32_t>& look,
                     int threads, const SlicePlanes& slices) {
    RelabelStats stats;
    std::vector<std::uint32_t> queue;
    count_before(find_suspects(mesh, look, threads), queue, stats);

    LabelDescent descent(mesh, options, slices);
    // Of one structure the subsegments that waiting would cost are worth more than a spike;
    // but a spike is no way round a cross-section that is spoiled.
    const bool one_structure = mesh.registry.table().members.size() <= 2;
    descent.allowed() = {one_structure && !slices.is_stack(), !slices.any(), !options.losses_wait};
    const auto work = [&] {
        work_through(descent, one_structure, queue, stats);
        if (!slices.is_stack()) work_in_depth(descent, one_structure, queue, stats);
    };
    std::vector<std::uint32_t> flat;
    parallel_tasks(threads, {work, [&] { flat = nearly_flat_cells(mesh.points, mesh.cells, threads); }});
    for (const std::uint32_t c : flat) stats.flat_cells_peeled += descent.peel(c);
    if (slices.any()) mend_sections(descent, wrong_cells(mesh, slices, look, threads), queue, stats);
    count_after(descent, queue, nonmanifold, stats);
    return stats;
}

}  // namespace anatomesh
