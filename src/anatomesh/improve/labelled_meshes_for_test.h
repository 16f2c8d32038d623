// For tests: meshes with regions, all vertices sound, and what may be expected after they have been worked
// on.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "anatomesh/cull/culled_mesh_for_test.h"
#include "anatomesh/cut/relabel.h"
#include "anatomesh/cut/resolve_nonmanifold.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh::fixtures {

struct LabelledCase {
    std::string name;
    AnalyticField field;
    std::uint32_t structures = 1;
    TetMesh mesh;
    RegionTable regions;
    std::vector<std::uint8_t> fixed;
};

// Relabels and splits until every surface is a manifold.
inline void make_sound(TetMesh& mesh, RegionRegistry& registry) {
    const std::vector<std::uint32_t> flat = cell_neighbors(mesh.cells, mesh.points.size());
    std::vector<CellNeighbors> neighbors(mesh.cells.size());
    for (std::size_t n = 0; n < flat.size(); ++n) neighbors[n / 4][n % 4] = flat[n];
    std::vector<std::uint32_t> nonmanifold;
    {
        const VertexStars stars(mesh.cells, mesh.points.size());
        relabel({mesh.points, mesh.cells, neighbors, stars, {}, {}, mesh.regions, registry}, {}, nonmanifold);
    }
    ASSERT_TRUE(resolve_nonmanifold(mesh, nonmanifold, {}, registry, {}).ok());
}

// The hull and every `every`-th vertex.
inline std::vector<std::uint8_t> fixed_vertices(const TetMesh& mesh, std::size_t every) {
    std::vector<std::uint8_t> fixed(mesh.points.size(), 0);
    for (std::size_t v = 0; v < fixed.size(); ++v) fixed[v] = v % every == 0;
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    for (std::size_t f = 0; f < neighbors.size(); ++f) {
        if (neighbors[f] != no_cell) continue;
        for (const int k : facet_vertices[f % 4]) fixed[mesh.cells[f / 4][k]] = 1;
    }
    return fixed;
}

// Sampled for a field, as the pipeline does it.
inline LabelledCase sampled_case(std::string name, AnalyticField field, std::uint32_t structures,
                                 std::size_t every = 10) {
    CulledMesh culled = culled_mesh(field, structures, 1);
    LabelledCase made{std::move(name), std::move(field), structures, culled.mesh(), {}, {}};
    make_sound(made.mesh, culled.registry);
    made.regions = culled.registry.table();
    made.fixed = fixed_vertices(made.mesh, every);
    return made;
}

// Random points, and these before them, nothing near any interface: cells take the region of their centroid.
inline LabelledCase random_case(std::string name, AnalyticField field, std::uint32_t structures,
                                std::uint32_t seed, std::vector<Vec3> points = {}) {
    std::mt19937 random(seed);
    const auto coordinate = [&] { return 20.0 * random() / 4294967296.0 - 10; };
    for (int n = 0; n < 2500; ++n) {
        const double x = coordinate(), y = coordinate(), z = coordinate();
        points.push_back({x, y, z});
    }
    for (int n = 0; n < 8; ++n)
        points.push_back({n & 1 ? 30.0 : -30.0, n & 2 ? 30.0 : -30.0, n & 4 ? 30.0 : -30.0});
    auto delaunay = Tetrahedralization::create(points);
    EXPECT_TRUE(delaunay.ok());
    const DelaunaySnapshot& snapshot = delaunay.value().snapshot();
    LabelledCase made{std::move(name), std::move(field), structures, {points, snapshot.cells, {}}, {}, {}};
    RegionRegistry registry;
    std::vector<std::uint32_t> members;
    for (const Cell& c : made.mesh.cells) {
        made.field.members(0.25 * (points[c[0]] + points[c[1]] + points[c[2]] + points[c[3]]), members);
        made.mesh.regions.push_back(registry.intern(members));
    }
    make_sound(made.mesh, registry);
    made.regions = registry.table();
    made.fixed = fixed_vertices(made.mesh, 25);
    return made;
}

inline std::vector<LabelledCase> labelled_cases() {
    std::vector<LabelledCase> cases;
    cases.push_back(sampled_case("ball", AnalyticField({ball({}, 5)}, 6), 1));
    cases.push_back(sampled_case("shell", AnalyticField({shell({}, 6, 4)}, 7), 1));
    cases.push_back(sampled_case("torus", AnalyticField({torus(6, 2.5)}, 9), 1));
    cases.push_back(
        sampled_case("touching balls", AnalyticField({ball({-4, 0, 0}, 4), ball({4, 0, 0}, 4)}, 9, true), 2));
    cases.push_back(
        sampled_case("overlapping balls", AnalyticField({ball({-2, 0, 0}, 4), ball({2, 0, 0}, 4)}, 7), 2));
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
        cases.push_back(random_case("random ball", AnalyticField({ball({}, 7)}, 9), 1, seed));
        cases.push_back(random_case("random torus", AnalyticField({torus(6, 2.5)}, 9), 1, seed));
        cases.push_back(random_case(
            "random halves", AnalyticField({ball({-3.5, 0, 0}, 6), ball({3.5, 0, 0}, 6)}, 9, true), 2, seed));
        cases.push_back(random_case("random overlap",
                                    AnalyticField({ball({-2, 0, 0}, 6), ball({2, 0, 0}, 6)}, 9), 2, seed));
    }
    return cases;
}

inline double sine_of(const TetMesh& mesh, const Cell& c) {
    return least_sine(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
}

inline double worst_sine(const TetMesh& mesh) {
    double worst = 1;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        if (mesh.regions[c] != 0) worst = std::min(worst, sine_of(mesh, mesh.cells[c]));
    }
    return worst;
}

inline double worst_ratio(const TetMesh& mesh) {
    double worst = 0;
    for (std::size_t n = 0; n < mesh.cells.size(); ++n) {
        const Cell& c = mesh.cells[n];
        if (mesh.regions[n] == 0) continue;
        worst = std::max(worst, radius_edge_ratio(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]],
                                                  mesh.points[c[3]]));
    }
    return worst;
}

// Of the cells of all regions.
inline double whole_volume(const TetMesh& mesh) {
    double sum = 0;
    for (const Cell& c : mesh.cells)
        sum += signed_volume(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
    return sum;
}

inline double structure_volume(const TetMesh& mesh, const RegionTable& regions, std::uint32_t structure) {
    double sum = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& v = mesh.cells[c];
        if (regions.contains(mesh.regions[c], structure))
            sum += signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
    }
    return sum;
}

// Positive cells, facets that match, the same space filled.
inline void expect_sound_mesh(const TetMesh& mesh, const TetMesh& before) {
    ASSERT_EQ(mesh.cells.size(), mesh.regions.size());
    for (const Cell& c : mesh.cells) {
        ASSERT_EQ(orient3d(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]), 1);
    }
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    const std::vector<std::uint32_t> neighbors_before = cell_neighbors(before.cells, before.points.size());
    EXPECT_EQ(std::count(neighbors.begin(), neighbors.end(), no_cell),
              std::count(neighbors_before.begin(), neighbors_before.end(), no_cell));
    EXPECT_NEAR(whole_volume(mesh), whole_volume(before), 1e-9 * whole_volume(before));
}

inline void expect_same_surfaces(const TetMesh& mesh, const TetMesh& before, const RegionTable& regions,
                                 std::uint32_t structures) {
    for (std::uint32_t s = 0; s < structures; ++s) {
        const SurfaceTopology now = surface_topology(structure_surface(mesh, regions, s));
        const SurfaceTopology was = surface_topology(structure_surface(before, regions, s));
        ASSERT_TRUE(was.closed_manifold());
        EXPECT_TRUE(now.closed_manifold());
        EXPECT_EQ(now.components, was.components);
        EXPECT_EQ(now.genus, was.genus);
        EXPECT_EQ(structure_pieces(mesh, regions, s), structure_pieces(before, regions, s));
    }
}

// The surfaces of all regions, the outside's too, are manifolds.
inline void expect_sound_regions(const TetMesh& mesh, const RegionTable& regions) {
    for (std::size_t r = 0; r < regions.members.size(); ++r) {
        RegionTable only;
        only.members.assign(regions.members.size(), {});
        only.members[r] = {0};
        const std::vector<Triangle> surface = structure_surface(mesh, only, 0);
        EXPECT_TRUE(surface.empty() || surface_topology(surface).closed_manifold()) << r;
    }
}

// A vertex, number 6, in the eight cells of an octahedron with its top and bottom at these heights.
inline TetMesh octahedron_round(Vec3 vertex, double top, double bottom) {
    TetMesh mesh;
    mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, top}, {0, 0, bottom}, vertex};
    for (std::uint32_t n = 0; n < 8; ++n) {
        Cell cell{n & 1, 2 + (n >> 1 & 1), 4 + (n >> 2 & 1), 6};
        const auto p = [&](int k) { return mesh.points[cell[static_cast<std::size_t>(k)]]; };
        if (orient3d(p(0), p(1), p(2), p(3)) < 0) std::swap(cell[0], cell[1]);
        mesh.cells.push_back(cell);
        mesh.regions.push_back(1);
    }
    return mesh;
}

// Vertices on the surface of a structure.
inline std::vector<std::uint8_t> on_surface(const TetMesh& mesh, const RegionTable& regions,
                                            std::uint32_t structure) {
    std::vector<std::uint8_t> on(mesh.points.size(), 0);
    for (const Triangle& f : structure_surface(mesh, regions, structure)) {
        for (const std::uint32_t v : f) on[v] = 1;
    }
    return on;
}

}  // namespace anatomesh::fixtures
