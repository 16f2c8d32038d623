#include "anatomesh/improve/smooth/smooth_vertices.h"

#include <array>
#include <cmath>
#include <numbers>

#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/sample/interface_probe.h"

namespace anatomesh::smooth_vertices_test {
namespace {

using namespace fixtures;

double mean_ratio(const TetMesh& mesh) {
    double sum = 0, count = 0;
    for (std::size_t n = 0; n < mesh.cells.size(); ++n) {
        const Cell& c = mesh.cells[n];
        if (mesh.regions[n] == 0) continue;
        sum += radius_edge_ratio(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
        ++count;
    }
    return sum / count;
}

std::vector<std::uint8_t> on_interfaces(const TetMesh& mesh) {
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    std::vector<std::uint8_t> on(mesh.points.size(), 0);
    for (std::size_t f = 0; f < neighbors.size(); ++f) {
        if (neighbors[f] == no_cell || mesh.regions[neighbors[f]] == mesh.regions[f / 4]) continue;
        for (const int k : facet_vertices[f % 4]) on[mesh.cells[f / 4][k]] = 1;
    }
    return on;
}

SmoothStats smoothed(LabelledCase& made, int passes, int threads = 1, double max_mean = HUGE_VAL,
                     const PlaneSides& slices = {}) {
    RunContext context;
    context.threads = threads;
    SmoothOptions options;
    options.passes = passes;
    options.max_mean = max_mean;
    options.slices = slices;
    const std::vector<std::uint32_t> neighbors = cell_neighbors(made.mesh.cells, made.mesh.points.size());
    const VertexStars stars(made.mesh.cells, made.mesh.points.size(), threads);
    return smooth_vertices({made.mesh, neighbors, stars, made.fixed, made.regions}, made.field,
                           made.structures, options, context);
}

TEST(SmoothVertices, lowers_the_mean_ratio_and_keeps_what_must_stay) {
    for (LabelledCase& made : labelled_cases()) {
        SCOPED_TRACE(made.name);
        const TetMesh before = made.mesh;
        const SmoothStats stats = smoothed(made, 3);
        EXPECT_EQ(made.mesh.cells, before.cells);
        EXPECT_EQ(made.mesh.regions, before.regions);
        for (std::size_t v = 0; v < made.fixed.size(); ++v) {
            if (made.fixed[v]) {
                ASSERT_EQ(made.mesh.points[v], before.points[v]);
            }
        }
        expect_sound_mesh(made.mesh, before);
        EXPECT_GT(stats.vertices_moved, 0u);
        EXPECT_LT(mean_ratio(made.mesh),
                  (made.name.starts_with("random") ? 0.95 : 0.99) * mean_ratio(before));
        EXPECT_LE(worst_ratio(made.mesh), std::max(2.0, worst_ratio(before)) + 1e-12);
        EXPECT_GE(worst_sine(made.mesh),
                  std::min(std::sin(16 * std::numbers::pi / 180), worst_sine(before)) - 1e-12);
    }
}

TEST(SmoothVertices, slides_vertices_along_the_interface_only) {
    for (const char* name : {"ball", "shell", "torus", "touching balls"}) {
        for (LabelledCase& made : labelled_cases()) {
            if (made.name != name) continue;
            SCOPED_TRACE(name);
            const TetMesh before = made.mesh;
            const SmoothStats stats = smoothed(made, 2);
            EXPECT_GT(stats.surface_vertices_moved, 0u);
            EXPECT_LT(stats.surface_vertices_moved, stats.vertices_moved);
            InterfaceProbe probe(made.field, made.structures);
            const std::vector<std::uint8_t> on = on_interfaces(made.mesh);
            for (std::size_t v = 0; v < on.size(); ++v) {
                if (!on[v] || made.mesh.points[v] == before.points[v]) continue;
                ASSERT_LE(probe.distance(made.mesh.points[v]), 0.0051);
            }
        }
    }
}

TEST(SmoothVertices, no_vertex_of_an_interface_passes_through_a_slice) {
    PlaneSides slices;
    slices.on_plane_mm = 1e-9;
    for (double at = -9; at < 9; at += 0.2) {
        slices.planes.push_back(make_plane({0, 0, at}, normalized(Vec3{0.3, at / 20, 1})));
        slices.extents.push_back({{-99, -99}, {99, 99}});
    }
    std::array<std::size_t, 2> passed{};
    for (const bool held : {false, true}) {
        LabelledCase made = labelled_cases()[0];
        const TetMesh before = made.mesh;
        const std::vector<std::uint8_t> on = on_interfaces(made.mesh);
        EXPECT_GT(smoothed(made, 2, 1, HUGE_VAL, held ? slices : PlaneSides{}).surface_vertices_moved, 0u);
        for (std::size_t v = 0; v < on.size(); ++v)
            passed[held] += on[v] && !slices.keeps(before.points[v], made.mesh.points[v]);
    }
    EXPECT_GT(passed[false], 0u);
    EXPECT_EQ(passed[true], 0u);
}

TEST(SmoothVertices, does_the_same_with_two_threads_and_nothing_in_no_pass) {
    LabelledCase one = labelled_cases()[1], two = labelled_cases()[1], none = labelled_cases()[1];
    const TetMesh before = none.mesh;
    smoothed(one, 3);
    smoothed(two, 3, 2);
    EXPECT_EQ(one.mesh.points, two.mesh.points);
    EXPECT_EQ(smoothed(none, 0).vertices_moved, 0u);
    EXPECT_EQ(none.mesh.points, before.points);
}

TEST(SmoothVertices, goes_on_for_smaller_gains_while_the_mean_is_above_what_is_asked) {
    for (LabelledCase& once : labelled_cases()) {
        LabelledCase even = once, evener = once, two_threads = once;
        SCOPED_TRACE(once.name);
        const TetMesh before = once.mesh;
        smoothed(once, 1);
        smoothed(even, 1, 1, mean_ratio(once.mesh) + 1e-4);
        EXPECT_EQ(even.mesh.points, once.mesh.points);
        smoothed(evener, 1, 1, 0.5);
        smoothed(two_threads, 1, 2, 0.5);
        EXPECT_EQ(evener.mesh.points, two_threads.mesh.points);
        EXPECT_LT(mean_ratio(evener.mesh), mean_ratio(once.mesh));
        EXPECT_LE(worst_ratio(evener.mesh), std::max(2.0, worst_ratio(before)) + 1e-12);
        EXPECT_GE(worst_sine(evener.mesh),
                  std::min(std::sin(16 * std::numbers::pi / 180), worst_sine(before)) - 1e-12);
    }
}

TEST(SmoothVertices, a_vertex_off_the_middle_of_its_neighbours_goes_there) {
    // Round one free vertex the corners of an octahedron: the best place is its centre, from wherever it
    // starts.
    for (const Vec3 start : {Vec3{0.4, 0.1, -0.2}, Vec3{-0.3, 0.3, 0.1}, Vec3{0, 0, 0.5}}) {
        TetMesh mesh = octahedron_round(start, 1, -1);
        RunContext context;
        SmoothOptions options;
        options.passes = 20;
        const AnalyticField field({ball({}, 50)}, 60);
        const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, 7);
        smooth_vertices({mesh, neighbors, VertexStars(mesh.cells, 7), {1, 1, 1, 1, 1, 1, 0}, {{{}, {0}}}},
                        field, 1, options, context);
        EXPECT_LT(length(mesh.points[6]), 0.12);
    }
}

}  // namespace
}  // namespace anatomesh::smooth_vertices_test
