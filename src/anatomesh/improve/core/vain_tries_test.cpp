#include "anatomesh/improve/core/vain_tries.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh {
namespace {

TEST(VainTries, are_worth_another_one_once_a_cell_at_a_vertex_of_theirs_has_changed) {
    const TetMesh mesh = testing::brick_mesh({2, 2, 2}, [](int, int, int) { return Region{1}; });
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    const EditMesh edited(mesh, neighbors);
    const VainTries::Name name{1, 2, 3, 0}, another{1, 2, 4, 0};
    const Cell first = mesh.cells.front();
    VainTries vain;
    EXPECT_FALSE(vain.contains(name, first));
    vain.add(name);
    EXPECT_TRUE(vain.contains(name, first));
    EXPECT_FALSE(vain.contains(another, first));

    vain.note_change(edited, std::array{0u, no_cell});
    EXPECT_FALSE(vain.contains(name, first));
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        const bool changed = std::find(first.begin(), first.end(), v) != first.end();
        EXPECT_EQ(vain.contains(name, std::array{v}), !changed) << v;
    }
    vain.add(name);
    EXPECT_TRUE(vain.contains(name, first));
}

}  // namespace
}  // namespace anatomesh
