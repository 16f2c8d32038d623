#include "anatomesh/mesh/edit/drop_outside.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::drop_outside_test {
namespace {
using testing::brick_mesh;

// Some cubes are of regions, the others outside: by a sum that leaves corners, edges and whole layers over.
Region region_of(int i, int j, int k, unsigned seed) {
    const unsigned mixed = (static_cast<unsigned>(i) * 7 + static_cast<unsigned>(j) * 13 +
                            static_cast<unsigned>(k) * 29 + seed) %
                           6;
    return mixed < 4 ? static_cast<Region>(mixed) : Region{0};
}

Vec3 place(int i, int j, int k) {
    return {1.5 * i, 2.0 * j, 0.5 * k};
}

// Cubes outside are made too, as region 5, which then becomes 0.
TetMesh with_outside(unsigned seed) {
    TetMesh mesh = brick_mesh(
        {5, 4, 3},
        [&](int i, int j, int k) {
            return region_of(i, j, k, seed) == 0 ? Region{5} : region_of(i, j, k, seed);
        },
        place);
    for (Region& region : mesh.regions) region = region == 5 ? Region{0} : region;
    return mesh;
}

TEST(DropOutside, LeavesTheMeshOfTheRegionsAlone) {
    for (unsigned seed = 0; seed < 6; ++seed) {
        for (const unsigned threads : {1u, 2u}) {
            const TetMesh whole = with_outside(seed);
            TetMesh mesh = whole;
            std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size(), 1);
            const std::vector<std::uint32_t> number = drop_outside(mesh, neighbors, threads);
            const TetMesh expected = brick_mesh(
                {5, 4, 3}, [&](int i, int j, int k) { return region_of(i, j, k, seed); }, place);
            EXPECT_EQ(mesh.points, expected.points);
            EXPECT_EQ(mesh.cells, expected.cells);
            EXPECT_EQ(mesh.regions, expected.regions);
            EXPECT_EQ(neighbors, cell_neighbors(mesh.cells, mesh.points.size(), 1));
            ASSERT_EQ(number.size(), whole.points.size());
            std::size_t kept = 0;
            for (std::size_t v = 0; v < number.size(); ++v) {
                if (number[v] == no_cell) continue;
                ++kept;
                EXPECT_EQ(mesh.points[number[v]], whole.points[v]);
            }
            EXPECT_EQ(kept, mesh.points.size());
        }
    }
}

TEST(DropOutside, OfNothingButOutsideNothingIsLeft) {
    TetMesh mesh = brick_mesh(
        {2, 1, 1}, [](int, int, int) { return Region{1}; }, place);
    for (Region& region : mesh.regions) region = 0;
    std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size(), 1);
    drop_outside(mesh, neighbors, 1);
    EXPECT_TRUE(mesh.points.empty() && mesh.cells.empty() && mesh.regions.empty() && neighbors.empty());
}

TEST(CompactRegions, NumbersDoNotDependOnTheOrderInWhichRegionsWereMet) {
    const std::vector<std::vector<std::uint32_t>> sets{{0}, {1}, {0, 1}, {2}};
    std::vector<std::size_t> order{0, 1, 2, 3};
    do {
        // Region r + 1 is sets[order[r]]; structure 2 has no cell.
        RegionTable table;
        TetMesh mesh = brick_mesh(
            {3, 1, 1}, [](int, int, int) { return Region{1}; }, place);
        for (const std::size_t n : order) table.members.push_back(sets[n]);
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const auto found = std::find(order.begin(), order.end(), c / 6);
            mesh.regions[c] = static_cast<Region>(1 + (found - order.begin()));
        }
        compact_regions(mesh, table);
        EXPECT_EQ(table.members, (std::vector<std::vector<std::uint32_t>>{{}, {0}, {1}, {0, 1}}));
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) EXPECT_EQ(mesh.regions[c], 1 + c / 6);
    } while (std::next_permutation(order.begin(), order.end()));
}

}  // namespace
}  // namespace anatomesh::drop_outside_test
