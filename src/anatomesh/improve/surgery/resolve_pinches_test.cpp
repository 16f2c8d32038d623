#include "anatomesh/improve/surgery/resolve_pinches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::resolve_pinches_test {
namespace {

using Cube = std::array<int, 3>;

// A structure in a block of 8 x 8 x 6 cubes, all of it but some that are outside; vertices within are shaken.
struct Pitted {
    TetMesh mesh;
    RegionTable table{{{}, {0}}};
    std::vector<std::uint32_t> neighbors;
    std::vector<std::uint8_t> fixed;
    std::vector<std::vector<std::uint32_t>> cells_of;  // by cube
    fixtures::AnalyticField field{{[](Vec3) { return -1.0; }}, 10};

    Pitted(const std::vector<Cube>& outside, unsigned seed) {
        mesh = testing::brick_mesh({8, 8, 6}, [](int, int, int) { return Region{1}; });
        cells_of.resize(8 * 8 * 6);
        for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 p;
            for (const std::uint32_t v : mesh.cells[c]) p += 0.25 * mesh.points[v];
            cells_of[index({static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)})].push_back(
                c);
        }
        for (const Cube& cube : outside) {
            for (const std::uint32_t c : cells_of[index(cube)]) mesh.regions[c] = 0;
        }
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> shift(-0.15, 0.15);
        for (Vec3& p : mesh.points) {
            const bool rim = p.x == 0 || p.x == 8 || p.y == 0 || p.y == 8 || p.z == 0 || p.z == 6;
            fixed.push_back(rim);
            if (!rim) p = p + Vec3{shift(random), shift(random), shift(random)};
        }
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    }

    static std::size_t index(Cube cube) {
        return static_cast<std::size_t>(cube[0] + 8 * cube[1] + 64 * cube[2]);
    }

    bool is_manifold() const { return surface_topology(structure_surface(mesh, table, 0)).closed_manifold(); }

    // Puts a cube outside, alone or with what joins it. Returns how many cells went besides.
    std::size_t put_outside(Cube cube, bool joined, double thickness = 0.4) {
        std::vector<std::uint32_t> relabelled = cells_of[index(cube)], membrane;
        for (const std::uint32_t c : relabelled)
            membrane.insert(membrane.end(), mesh.cells[c].begin(), mesh.cells[c].end());
        sort_distinct(membrane);
        const std::size_t alone = relabelled.size();
        EditMesh edited(std::move(mesh), neighbors);
        EditContext edit(edited, fixed, {}, field, 1, {});
        edit.table = &table;
        if (joined) {
            auto all = resolve_pinches(
                edit, {0, 1, 0, false, thickness, membrane, static_cast<std::uint32_t>(edited.point_count())},
                relabelled);
            EXPECT_TRUE(all);
            relabelled = std::move(*all);
            // They have the regions they had.
            for (const std::uint32_t c : relabelled) EXPECT_EQ(edited.region(c), 1);
        }
        for (const std::uint32_t c : relabelled) edited.set_region(c, 0);
        mesh = std::move(edited).take(neighbors);
        return relabelled.size() - std::min(relabelled.size(), alone);
    }

    double outside_volume() const {
        double sum = 0;
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const Cell& v = mesh.cells[c];
            const Vec3 a = mesh.points[v[0]];
            const double six =
                dot(cross(mesh.points[v[1]] - a, mesh.points[v[2]] - a), mesh.points[v[3]] - a);
            EXPECT_GT(six, 0);
            if (mesh.regions[c] == 0) sum += six / 6;
        }
        return sum;
    }
};

TEST(ResolvePinches, what_meets_the_other_side_in_facets_stays_alone) {
    Pitted block({{2, 2, 2}}, 1);
    EXPECT_EQ(block.put_outside({3, 2, 2}, true), 0u);
    EXPECT_TRUE(block.is_manifold());
}

TEST(ResolvePinches, cubes_that_meet_in_an_edge_or_a_vertex_are_joined) {
    for (const Cube cube : {Cube{3, 3, 2}, Cube{3, 2, 3}, Cube{2, 3, 3}, Cube{3, 3, 3}, Cube{1, 3, 3}}) {
        for (unsigned seed = 0; seed < 5; ++seed) {
            Pitted alone({{2, 2, 2}}, seed), joined({{2, 2, 2}}, seed);
            alone.put_outside(cube, false);
            EXPECT_FALSE(alone.is_manifold());
            EXPECT_GT(joined.put_outside(cube, true), 0u);
            EXPECT_TRUE(joined.is_manifold()) << cube[0] << cube[1] << cube[2] << " " << seed;
            // Near the edge, or the vertex.
            EXPECT_LT(joined.outside_volume(), alone.outside_volume() + 1);
        }
    }
}

TEST(ResolvePinches, the_thinner_the_less_goes) {
    double last = 1e9;
    for (const double thickness : {0.5, 0.3, 0.15}) {
        Pitted block({{2, 2, 2}}, 3);
        block.put_outside({3, 3, 3}, true, thickness);
        EXPECT_TRUE(block.is_manifold());
        EXPECT_LT(block.outside_volume(), last);
        last = block.outside_volume();
    }
}

// Several cubes outside already: most are joined, and no cell is turned over.
TEST(ResolvePinches, cubes_among_any_others_are_joined_mostly) {
    int tried = 0, done = 0;
    for (unsigned seed = 0; seed < 300; ++seed) {
        std::mt19937 random(seed);
        std::vector<Cube> outside;
        const auto any = [&] { return 2 + static_cast<int>(random() % 3); };
        for (int n = 0; n < 3; ++n) {
            const int x = any(), y = any(), z = 1 + any() % 4;
            outside.push_back({x, y, z});
        }
        const int x = any(), y = any(), z = 1 + any() % 4;
        const Cube cube{x, y, z};
        if (std::find(outside.begin(), outside.end(), cube) != outside.end()) continue;
        Pitted alone(outside, seed), joined(outside, seed);
        if (!alone.is_manifold()) continue;
        alone.put_outside(cube, false);
        if (alone.is_manifold()) continue;
        ++tried;
        joined.put_outside(cube, true);
        joined.outside_volume();
        done += joined.is_manifold();
    }
    EXPECT_GT(tried, 20);
    EXPECT_GE(done, 0.9 * tried);
}

}  // namespace
}  // namespace anatomesh::resolve_pinches_test
