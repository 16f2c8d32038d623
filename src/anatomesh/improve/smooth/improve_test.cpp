#include "anatomesh/improve/smooth/improve.h"

#include <atomic>
#include <numbers>
#include <numeric>

#include "anatomesh/cull/culled_mesh_for_test.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/smooth/balance_volumes.h"
#include "anatomesh/improve/smooth/vertex_mover.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"

namespace anatomesh::improve_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

void expect_positive(const TetMesh& mesh) {
    for (const Cell& c : mesh.cells) {
        ASSERT_EQ(orient3d(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]), 1);
    }
}

double worst_inside(const TetMesh& mesh) {
    double worst = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& cell = mesh.cells[c];
        if (mesh.regions[c] == 0) continue;
        worst = std::max(worst, radius_edge_ratio(mesh.points[cell[0]], mesh.points[cell[1]],
                                                  mesh.points[cell[2]], mesh.points[cell[3]]));
    }
    return worst;
}

std::vector<double> volumes_of(const TetMesh& mesh, const RegionTable& regions, std::size_t structures) {
    std::vector<double> volumes(structures, 0);
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& v = mesh.cells[c];
        for (const std::uint32_t s : regions.members[mesh.regions[c]]) {
            volumes[s] +=
                signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
        }
    }
    return volumes;
}

// The hull's corners and every tenth vertex are fixed.
std::vector<std::uint8_t> some_fixed(const TetMesh& mesh) {
    std::vector<std::uint8_t> fixed(mesh.points.size(), 0);
    for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = v % 10 == 0 || length(mesh.points[v]) > 12;
    return fixed;
}

struct Solid {
    const char* name;
    AnalyticField field;
    std::vector<double> volumes;
};

std::vector<Solid> solids() {
    std::vector<Solid> list;
    list.push_back({"ball", AnalyticField({ball({}, 5)}, 6), {4 / 3.0 * pi * 125}});
    list.push_back({"shell", AnalyticField({shell({}, 6, 4)}, 7), {4 / 3.0 * pi * (216 - 64)}});
    list.push_back({"torus", AnalyticField({torus(6, 2.5)}, 9), {2 * pi * pi * 6 * 6.25}});
    list.push_back({"touching balls",
                    AnalyticField({ball({-4, 0, 0}, 4), ball({4, 0, 0}, 4)}, 9, true),
                    {4 / 3.0 * pi * 64, 4 / 3.0 * pi * 64}});
    list.push_back({"overlapping balls",
                    AnalyticField({ball({-2, 0, 0}, 4), ball({2, 0, 0}, 4)}, 7),
                    {4 / 3.0 * pi * 64, 4 / 3.0 * pi * 64}});
    return list;
}

VertexStars stars_of(const TetMesh& mesh) {
    return VertexStars(mesh.cells, mesh.points.size());
}

TEST(Improve, keeps_fixed_vertices_orientation_and_connectivity_and_makes_nothing_worse) {
    for (const Solid& solid : solids()) {
        SCOPED_TRACE(solid.name);
        const auto structures = static_cast<std::uint32_t>(solid.volumes.size());
        const CulledMesh culled = culled_mesh(solid.field, structures, 1);
        const TetMesh before = culled.mesh();
        TetMesh mesh = before;
        const std::vector<std::uint8_t> fixed = some_fixed(mesh);
        RunContext context;
        const ImproveStats stats = improve(mesh, stars_of(mesh), fixed, solid.field, structures,
                                           culled.registry.table(), {}, context);
        expect_positive(mesh);
        EXPECT_EQ(mesh.cells, before.cells);
        EXPECT_EQ(mesh.regions, before.regions);
        for (std::size_t v = 0; v < fixed.size(); ++v) {
            ASSERT_TRUE(!fixed[v] || mesh.points[v] == before.points[v]);
        }
        EXPECT_LE(stats.above_bound_after, stats.above_bound_before);
        EXPECT_LE(worst_inside(mesh), std::max(2.0, worst_inside(before)));
        TetMesh by_threads = before;
        context.threads = 3;
        improve(by_threads, stars_of(by_threads), fixed, solid.field, structures, culled.registry.table(), {},
                context);
        EXPECT_EQ(by_threads.points, mesh.points);
    }
}

// Vertices of a ball's surface pushed off it come back.
TEST(Improve, brings_vertices_of_the_surface_back_onto_the_interface) {
    const AnalyticField field({ball({}, 5)}, 6);
    TetMesh mesh = culled_mesh(field, 1, 1).mesh();
    std::vector<std::uint32_t> surface;
    const VertexStars stars = stars_of(mesh);
    VertexMover mover(mesh, stars, 2);
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        if (std::abs(length(mesh.points[v]) - 5) < 0.01 && mover.try_move(v, 1.03 * mesh.points[v]))
            surface.push_back(v);
    }
    ASSERT_GT(surface.size(), 100u);
    RunContext context;
    const ImproveStats stats = improve(mesh, stars, std::vector<std::uint8_t>(mesh.points.size(), 0), field,
                                       1, {{{}, {0}}}, {}, context);
    EXPECT_GT(stats.vertices_onto_interface, 0u);
    std::size_t off = 0;
    for (const std::uint32_t v : surface) off += std::abs(length(mesh.points[v]) - 5) > 0.06;
    EXPECT_LT(off * 20, surface.size());
}

TEST(VertexMover, moves_at_one_time_only_vertices_that_share_no_cell) {
    const AnalyticField field({ball({}, 5)}, 6);
    TetMesh mesh = culled_mesh(field, 1, 1).mesh();
    std::vector<std::uint32_t> all(mesh.points.size());
    std::iota(all.begin(), all.end(), 0u);
    std::vector<std::uint32_t> last;
    for (const int threads : {1, 3}) {
        const VertexStars by_threads(mesh.cells, mesh.points.size(), threads);
        const VertexMover mover(mesh, by_threads, 2);
        std::vector<std::atomic<int>> busy(mesh.cells.size());
        std::vector<std::atomic<int>> count(mesh.points.size());
        mover.for_each_apart(all, threads, [&](std::uint32_t v) {
            for (const std::uint32_t c : mover.star(v)) EXPECT_EQ(busy[c]++, 0);
            ++count[v];
            for (const std::uint32_t c : mover.star(v)) --busy[c];
        });
        for (const std::atomic<int>& n : count) EXPECT_EQ(n, 1);
        std::vector<std::uint32_t> stars;
        for (const std::uint32_t v : all)
            stars.insert(stars.end(), mover.star(v).begin(), mover.star(v).end());
        if (threads > 1) {
            EXPECT_EQ(stars, last);
        }
        last = stars;
    }
}

TEST(VertexMover, refuses_to_invert_a_cell) {
    const AnalyticField field({ball({}, 5)}, 6);
    TetMesh mesh = culled_mesh(field, 1, 1).mesh();
    const VertexStars stars = stars_of(mesh);
    VertexMover mover(mesh, stars, 1e9);
    for (std::uint32_t v = 0; v < mesh.points.size(); v += 7) {
        const Vec3 from = mesh.points[v];
        EXPECT_FALSE(mover.try_move(v, from + Vec3{50, 0, 0}));
        EXPECT_EQ(mesh.points[v], from);
    }
    expect_positive(mesh);
}

std::vector<std::uint32_t> neighbors_of(const TetMesh& mesh) {
    return cell_neighbors(mesh.cells, mesh.points.size());
}

BalanceStats balanced(TetMesh& mesh, const RegionTable& regions, const std::vector<std::uint8_t>& fixed,
                      std::span<const double> target_mm3, const BalanceOptions& options) {
    const std::vector<std::uint32_t> neighbors = neighbors_of(mesh);
    const VertexStars stars = stars_of(mesh);
    return balance_volumes({mesh, neighbors, stars, fixed, regions}, target_mm3, options);
}

TEST(BalanceVolumes, meets_the_targets_and_moves_no_fixed_vertex) {
    for (const Solid& solid : solids()) {
        SCOPED_TRACE(solid.name);
        const auto structures = static_cast<std::uint32_t>(solid.volumes.size());
        const CulledMesh culled = culled_mesh(solid.field, structures, 1);
        const TetMesh before = culled.mesh();
        TetMesh mesh = before;
        const std::vector<std::uint8_t> fixed = some_fixed(mesh);
        const BalanceStats stats = balanced(mesh, culled.registry.table(), fixed, solid.volumes, {});
        expect_positive(mesh);
        EXPECT_EQ(mesh.cells, before.cells);
        EXPECT_EQ(mesh.regions, before.regions);
        double largest = 0;
        for (std::size_t v = 0; v < fixed.size(); ++v) {
            ASSERT_TRUE(!fixed[v] || mesh.points[v] == before.points[v]);
            largest = std::max(largest, length(mesh.points[v] - before.points[v]));
        }
        EXPECT_LE(largest, 0.5 * (1 + 1e-9));
        EXPECT_NEAR(stats.largest_offset_mm, largest, 1e-9);
        EXPECT_GT(stats.worst_before, 2e-4);
        EXPECT_LT(stats.worst_after, 2e-3);
        const std::vector<double> volumes = volumes_of(mesh, culled.registry.table(), structures);
        double worst = 0;
        for (std::uint32_t s = 0; s < structures; ++s) {
            worst = std::max(worst, std::abs(volumes[s] - solid.volumes[s]) / solid.volumes[s]);
        }
        EXPECT_NEAR(stats.worst_after, worst, 1e-9);
        EXPECT_LE(worst_inside(mesh), std::max(2.0, worst_inside(before)));
    }
}

TEST(BalanceVolumes, does_nothing_when_the_volumes_are_right) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh culled = culled_mesh(field, 1, 1);
    TetMesh mesh = culled.mesh();
    const std::vector<double> volumes = volumes_of(mesh, culled.registry.table(), 1);
    const BalanceStats stats = balanced(mesh, culled.registry.table(),
                                        std::vector<std::uint8_t>(mesh.points.size(), 0), volumes, {});
    EXPECT_EQ(stats.moves, 0u);
    EXPECT_EQ(mesh.points, culled.points());
}

TEST(BalanceVolumes, no_vertex_passes_through_a_slice) {
    for (const Solid& solid : solids()) {
        SCOPED_TRACE(solid.name);
        const auto structures = static_cast<std::uint32_t>(solid.volumes.size());
        const CulledMesh culled = culled_mesh(solid.field, structures, 1);
        // Planes so close that a good part of the vertices would have to pass through one.
        BalanceOptions options;
        options.slices.on_plane_mm = 1e-9;
        ParallelPlanes& stack = options.slices.stack;
        stack.frame = make_plane({}, {0.3, -0.2, 1});
        for (double height = -50; height < 50; height += 0.05) stack.heights.push_back(height);
        std::array<std::size_t, 2> passed{};
        for (const bool held : {false, true}) {
            TetMesh mesh = culled.mesh();
            const BalanceOptions slices = held ? options : BalanceOptions{};
            const BalanceStats stats =
                balanced(mesh, culled.registry.table(), some_fixed(mesh), solid.volumes, slices);
            for (std::size_t v = 0; v < mesh.points.size(); ++v) {
                const auto level = [&](Vec3 p) { return stack.level(p, options.slices.on_plane_mm); };
                passed[held] += level(mesh.points[v]) != level(culled.points()[v]);
            }
            EXPECT_GT(stats.moves, 0u);
            EXPECT_LT(stats.worst_after, stats.worst_before);
            expect_positive(mesh);
        }
        EXPECT_GT(passed[false], 0u);
        EXPECT_EQ(passed[true], 0u);
    }
}

TEST(BalanceVolumes, a_target_out_of_reach_stops_at_the_largest_offset) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh culled = culled_mesh(field, 1, 1);
    TetMesh mesh = culled.mesh();
    BalanceOptions options;
    options.max_offset_mm = 0.05;
    const double target[] = {1000};
    const BalanceStats stats = balanced(mesh, culled.registry.table(),
                                        std::vector<std::uint8_t>(mesh.points.size(), 0), target, options);
    EXPECT_LE(stats.largest_offset_mm, 0.05 * (1 + 1e-12));
    EXPECT_LE(stats.worst_after, stats.worst_before);
    expect_positive(mesh);
}

}  // namespace
}  // namespace anatomesh::improve_test
