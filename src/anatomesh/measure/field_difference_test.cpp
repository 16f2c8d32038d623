#include "anatomesh/measure/field_difference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::field_difference_test {
namespace {

const std::vector<Structure> two{{1, "one", {1, 2, 3}}, {2, "two", {4, 5, 6}}};
const RegionTable apart{{{}, {0}, {1}}};
const std::vector<std::uint32_t> both{0, 1};

using Cubes = std::function<Region(int, int, int)>;

constexpr int side = 9;

// Whole cubes inside a structure: the sign is right everywhere, and the size says nothing.
fixtures::Distance of_cubes(const Cubes& cubes, Region region) {
    return [=](Vec3 p) {
        const auto i = static_cast<int>(std::floor(p.x)), j = static_cast<int>(std::floor(p.y)),
                   k = static_cast<int>(std::floor(p.z));
        const bool inside =
            i >= 0 && j >= 0 && k >= 0 && i < side && j < side && k < side && cubes(i, j, k) == region;
        return inside ? -1.0 : 1.0;
    };
}

FieldDifferenceReport compared(const Cubes& meshed, const Cubes& told, Vec3 origin = {}, int threads = 1,
                               const std::vector<std::uint32_t>& of_field = both) {
    TetMesh mesh = testing::brick_mesh({side, side, side}, meshed);
    for (Vec3& p : mesh.points) p = p + origin;
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    std::vector<std::vector<Triangle>> surfaces;
    for (std::uint32_t s = 0; s < two.size(); ++s)
        surfaces.push_back(structure_surface(mesh, neighbors, apart, s));
    const fixtures::AnalyticField field({of_cubes(told, 1), of_cubes(told, 2)}, side);
    return field_difference(mesh.points, surfaces, two, of_field, field, origin, threads);
}

// Bodies of many cubes, with holes, edges that four of them share and corners that touch; the facets lie on
// the grid, and most run along the columns.
Cubes scattered(unsigned seed) {
    return [=](int i, int j, int k) {
        const unsigned mixed = (static_cast<unsigned>(i) * 73856093u) ^
                               (static_cast<unsigned>(j) * 19349663u) ^
                               (static_cast<unsigned>(k) * 83492791u) ^ (seed * 2654435761u);
        return static_cast<Region>((mixed >> 7) % 3);
    };
}

TEST(FieldDifference, a_model_of_the_field_itself_differs_nowhere) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        for (const Vec3 origin : {Vec3{}, Vec3{100, -20, 3}}) {
            const FieldDifferenceReport report = compared(scattered(seed), scattered(seed), origin);
            EXPECT_GT(report.points, 500u);
            EXPECT_EQ(report.differing, 0u) << seed;
            EXPECT_EQ(report.max_mm, 0);
        }
    }
}

// A plate two cubes thick of structure 1 on a plate of structure 2.
Region plates(int, int, int k) {
    return k < 2 ? Region{1} : k < 4 ? Region{2} : Region{0};
}

TEST(FieldDifference, a_part_that_is_missing_and_one_too_many_are_told_with_how_deep) {
    const Cubes torn = [](int i, int j, int k) {
        return i >= 2 && i < 7 && j >= 2 && j < 7 && k < 2 ? Region{0} : plates(i, j, k);
    };
    // From the middle of the hole the nearest wall is 2.5 away.
    const FieldDifferenceReport missing = compared(torn, plates);
    EXPECT_TRUE(missing.missing);
    EXPECT_EQ(missing.structure, "one");
    EXPECT_NEAR(missing.max_mm, 2.2, 0.35);
    EXPECT_GT(missing.differing, 10u);
    const FieldDifferenceReport more = compared(plates, torn);
    EXPECT_FALSE(more.missing);
    EXPECT_EQ(more.structure, "one");
    // The plate is two thick, and no point is further than half the lattice's width from its middle.
    EXPECT_GT(more.max_mm, 0.4);
    EXPECT_LE(more.max_mm, 1);
    // Far from the origin, and by more threads, the same.
    const FieldDifferenceReport again = compared(torn, plates, {}, 4);
    EXPECT_EQ(again.max_mm, missing.max_mm);
    EXPECT_EQ(again.at, missing.at);
    EXPECT_NEAR(compared(torn, plates, {64, 512, -128}).at[0], missing.at[0] + 64, 1e-9);
}

TEST(FieldDifference, a_structure_without_its_field_is_left_out) {
    const Cubes none = [](int, int, int) { return Region{0}; };
    EXPECT_GT(compared(plates, none).max_mm, 0.4);
    EXPECT_EQ(compared(plates, none, {}, 1, {no_cell, no_cell}).points, 0u);
}

}  // namespace
}  // namespace anatomesh::field_difference_test
