// For tests: the Delaunay mesh of points sampled for an analytic field, every cell with its region.
#pragma once

#include <gtest/gtest.h>

#include <numeric>
#include <utility>
#include <vector>

#include "anatomesh/cull/cull.h"
#include "anatomesh/cull/labelled_mesh_view.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh/sample/analytic_field_for_test.h"
#include "anatomesh/sample/sample_points.h"

namespace anatomesh::fixtures {

struct CulledMesh {
    Tetrahedralization delaunay;
    DelaunaySnapshot cells;
    std::vector<VertexMembership> memberships;
    std::vector<Region> regions;
    RegionRegistry registry;
    CullStats stats;
    PointGrid grid;

    const std::vector<Vec3>& points() const { return delaunay.points(); }
    std::vector<std::uint32_t> all_cells() const {
        std::vector<std::uint32_t> all(cells.cells.size());
        std::iota(all.begin(), all.end(), 0u);
        return all;
    }
    TetMesh mesh() const { return {points(), cells.cells, regions}; }
    LabelledMeshView view(const StructureField& field, std::uint32_t structures = 1) const {
        return {points(),    cells.cells,      cells.neighbors, regions,
                memberships, registry.table(), field,           structures};
    }

    void update(const StructureField& field, std::uint32_t structures, SurfaceTolerance tolerance,
                int threads = 1) {
        RunContext context;
        context.threads = threads;
        cells = delaunay.snapshot();
        regions.resize(cells.cells.size());
        const std::vector<std::uint32_t> all = all_cells();
        const ChosenCells chosen{points(), cells.cells, all};
        find_memberships(chosen, field, structures, tolerance, memberships, registry, context);
        stats = cull(chosen, memberships, field, structures, regions, registry, context);
        for (std::size_t n = grid.size(); n < points().size(); ++n) grid.add(points()[n]);
    }
    double volume(std::uint32_t structure) const {
        double sum = 0;
        for (std::size_t c = 0; c < cells.cells.size(); ++c) {
            const Cell& cell = cells.cells[c];
            if (!registry.table().contains(regions[c], structure)) continue;
            sum += signed_volume(points()[cell[0]], points()[cell[1]], points()[cell[2]], points()[cell[3]]);
        }
        return sum;
    }
};

// Of these points and the corners of a large box.
inline CulledMesh culled_mesh_of(std::vector<Vec3> points, const StructureField& field, double size) {
    for (int corner = 0; corner < 8; ++corner)
        points.push_back({corner & 1 ? 20.0 : -20.0, corner & 2 ? 20.0 : -20.0, corner & 4 ? 20.0 : -20.0});
    CulledMesh mesh{Tetrahedralization::create(points).value(), {}, {}, {}, {}, {}, PointGrid(size, 1000)};
    mesh.update(field, 1, {0.02});
    return mesh;
}

inline CulledMesh culled_mesh(const StructureField& field, std::uint32_t structures, double size,
                              int threads = 1) {
    ContourSet no_contours;
    no_contours.structures.resize(structures);
    RunContext context;
    SampleOptions options;
    options.size_mm = size;
    auto sample = sample_points(no_contours, {}, field, options, context);
    EXPECT_TRUE(sample.ok());
    auto delaunay = Tetrahedralization::create(sample.value().points);
    EXPECT_TRUE(delaunay.ok());
    CulledMesh mesh{std::move(delaunay).value(), {}, {}, {}, {}, {}, PointGrid(size, 1000)};
    mesh.update(field, structures, {0.02 * size}, threads);
    return mesh;
}

}  // namespace anatomesh::fixtures
