#include "anatomesh_io/dicom/voxelize.h"

#include <gtest/gtest.h>

#include <cmath>

namespace anatomesh::voxelize_test {
namespace {

// A box of n^3 cubes, six cells each (Kuhn); region 1 where x < half, 2 beyond.
TetMesh box_mesh(int n, double size) {
    TetMesh mesh;
    const auto at = [&](int i, int j, int k) {
        return static_cast<std::uint32_t>((k * (n + 1) + j) * (n + 1) + i);
    };
    for (int k = 0; k <= n; ++k)
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) mesh.points.push_back({i * size / n, j * size / n, k * size / n});
    constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i)
                for (int o = 0; o < 6; ++o) {
                    int p[3] = {i, j, k};
                    Cell cell;
                    cell[0] = at(p[0], p[1], p[2]);
                    for (int s = 0; s < 3; ++s) {
                        ++p[orders[o][s]];
                        cell[static_cast<std::size_t>(s) + 1] = at(p[0], p[1], p[2]);
                    }
                    if (o >= 3) std::swap(cell[1], cell[2]);
                    mesh.cells.push_back(cell);
                    mesh.regions.push_back(2 * i < n ? 1 : 2);
                }
    return mesh;
}

TEST(Voxelize, voxels_of_a_box_without_gaps) {
    RunContext context;
    const TetMesh mesh = box_mesh(4, 8);
    // Voxel centres on corners, edges and facets of the cells, and off them; an oblique grid.
    for (const double step : {0.5, 1.0, 0.37})
        for (const double shear : {0.0, 0.25}) {
            ImageGeometry geometry;
            geometry.size = {30, 30, 30};
            geometry.origin = {-1, -1, -1};
            geometry.step = {Vec3{step, 0, 0}, Vec3{0, step, 0}, Vec3{shear * step, 0, step}};
            const auto regions = voxelize(mesh, geometry, context);
            for (std::uint32_t k = 0; k < 30; ++k)
                for (std::uint32_t j = 0; j < 30; ++j)
                    for (std::uint32_t i = 0; i < 30; ++i) {
                        const Vec3 p = geometry.position(i, j, k);
                        const bool is_in =
                            p.x >= 0 && p.x <= 8 && p.y >= 0 && p.y <= 8 && p.z >= 0 && p.z <= 8;
                        const auto region = regions[geometry.index(i, j, k)];
                        ASSERT_EQ(region != 0, is_in) << p.x << " " << p.y << " " << p.z;
                        if (is_in && p.x != 4) {
                            ASSERT_EQ(region, p.x < 4 ? 1 : 2);
                        }
                    }
        }
}

TEST(Voxelize, a_grid_around_holds_all_of_it) {
    const TetMesh mesh = box_mesh(2, 5);
    for (const double size : {0.3, 1.0, 7.0}) {
        const ImageGeometry geometry = grid_around(mesh, size);
        const Vec3 end = geometry.position(geometry.size[0] - 1, geometry.size[1] - 1, geometry.size[2] - 1);
        EXPECT_EQ(geometry.origin, (Vec3{0, 0, 0}));
        EXPECT_GE(end.x, 5);
        EXPECT_GE(end.y, 5);
        EXPECT_GE(end.z, 5);
    }
}

}  // namespace
}  // namespace anatomesh::voxelize_test
