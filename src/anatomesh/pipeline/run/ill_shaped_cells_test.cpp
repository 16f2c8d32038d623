#include "anatomesh/pipeline/run/ill_shaped_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace anatomesh::ill_shaped_cells_test {
namespace {

// A cell of height h over a right-angled base: at 10 degrees between base and slope, and at ratio 4 as it
// gets higher, it becomes ill-shaped; one of no structure never does.
TEST(IllShapedCells, are_those_beyond_the_bounds_of_a_cell_that_nothing_forces) {
    for (const double h : {1.0, 0.3, 0.1, 0.02, 3.0, 40.0}) {
        TetMesh mesh;
        mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1.0 / 3, 1.0 / 3, h}};
        mesh.cells = {{0, 1, 2, 3}, {0, 1, 2, 3}};
        mesh.regions = {1, 0};
        const double shortest = std::sqrt(2.0 / 9 + h * h), distance = 1.0 / 3 / std::sqrt(2);
        const bool is_flat = std::atan2(h, 1.0 / 3) < 10 * std::numbers::pi / 180 ||
                             std::atan2(h, distance) < 10 * std::numbers::pi / 180;
        // The sphere through all corners has its middle above that of the base's longest side.
        const double up = (h * h + 2.0 / 9 - 2.0 / 3) / (2 * h);
        const double ratio = std::hypot(std::sqrt(0.5), up) / std::min(1.0, shortest);
        const bool is_ill = is_flat || ratio > 4;
        EXPECT_EQ(ill_shaped_cells(mesh, 1).size(), is_ill ? 1u : 0u) << h;
        if (is_ill) {
            EXPECT_EQ(ill_shaped_cells(mesh, 2).front(), 0u);
        }
    }
}

}  // namespace
}  // namespace anatomesh::ill_shaped_cells_test
