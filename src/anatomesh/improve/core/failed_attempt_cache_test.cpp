#include "anatomesh/improve/core/failed_attempt_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"

namespace anatomesh::failed_attempt_cache_test {
namespace {

TEST(FailedAttemptCache, are_worth_another_one_once_a_cell_at_a_vertex_of_theirs_has_changed) {
    const TetMesh mesh = testing::brick_mesh({2, 2, 2}, [](int, int, int) { return Region{1}; });
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    const EditMesh edited(mesh, neighbors);
    const FailedAttemptCache::Name name{1, 2, 3, 0}, another{1, 2, 4, 0};
    const Cell first = mesh.cells.front();
    FailedAttemptCache cache;
    EXPECT_FALSE(cache.contains(name, first));
    cache.add(name);
    EXPECT_TRUE(cache.contains(name, first));
    EXPECT_FALSE(cache.contains(another, first));

    cache.note_change(edited, std::array{0u, no_cell});
    EXPECT_FALSE(cache.contains(name, first));
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
        const bool changed = std::find(first.begin(), first.end(), v) != first.end();
        EXPECT_EQ(cache.contains(name, std::array{v}), !changed) << v;
    }
    cache.add(name);
    EXPECT_TRUE(cache.contains(name, first));
}

}  // namespace
}  // namespace anatomesh::failed_attempt_cache_test
