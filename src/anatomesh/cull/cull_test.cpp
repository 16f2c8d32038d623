#include "anatomesh/cull/cull.h"

#include <numbers>

#include "anatomesh/cull/culled_mesh_for_test.h"

namespace anatomesh::cull_test {
namespace {

using namespace fixtures;

constexpr double pi = std::numbers::pi;

void expect_share(double value, double expected, double share) {
    EXPECT_NEAR(value, expected, share * expected);
}

TEST(Cull, the_kept_cells_have_the_volume_of_the_solid) {
    expect_share(culled_mesh(AnalyticField({ball({}, 5)}, 6), 1, 1).volume(0), 4 / 3.0 * pi * 125, 0.03);
    expect_share(culled_mesh(AnalyticField({shell({}, 6, 4)}, 7), 1, 1).volume(0), 4 / 3.0 * pi * (216 - 64),
                 0.03);
    expect_share(culled_mesh(AnalyticField({torus(6, 2.5)}, 9), 1, 1).volume(0), 2 * pi * pi * 6 * 6.25,
                 0.03);
}

// All vertices of such a shell's cells lie on its two walls.
TEST(Cull, a_shell_thinner_than_a_cell_keeps_its_volume) {
    for (const auto& [thickness, share] : {std::pair{0.8, 0.1}, {0.6, 0.2}}) {
        const double inner = 6 - thickness;
        const CulledMesh mesh = culled_mesh(AnalyticField({shell({}, 6, inner)}, 7), 1, 1);
        expect_share(mesh.volume(0), 4 / 3.0 * pi * (216 - inner * inner * inner), share);
    }
}

TEST(Cull, touching_balls_that_exclude_each_other_share_no_cell) {
    const AnalyticField field({ball({-4, 0, 0}, 4), ball({4, 0, 0}, 4)}, 9, true);
    const CulledMesh mesh = culled_mesh(field, 2, 1);
    for (const Region region : mesh.regions) ASSERT_LE(mesh.registry.table().members[region].size(), 1u);
    for (const std::uint32_t s : {0, 1}) expect_share(mesh.volume(s), 4 / 3.0 * pi * 64, 0.05);
}

TEST(Cull, overlapping_balls_make_three_regions_and_keep_their_volumes) {
    const AnalyticField field({ball({-2, 0, 0}, 4), ball({2, 0, 0}, 4)}, 7);
    const CulledMesh mesh = culled_mesh(field, 2, 0.8);
    EXPECT_EQ(mesh.registry.table().members.size(), 4u);
    for (const std::uint32_t s : {0, 1}) expect_share(mesh.volume(s), 4 / 3.0 * pi * 64, 0.04);
    double both = 0;
    for (std::size_t c = 0; c < mesh.cells.cells.size(); ++c) {
        const Cell& cell = mesh.cells.cells[c];
        if (mesh.registry.table().members[mesh.regions[c]].size() < 2) continue;
        both += signed_volume(mesh.points()[cell[0]], mesh.points()[cell[1]], mesh.points()[cell[2]],
                              mesh.points()[cell[3]]);
    }
    // Two caps of height 2.
    expect_share(both, 2 * pi * 4 * (12 - 2) / 3, 0.08);
}

TEST(Cull, cells_of_a_grid_away_from_the_surface_are_as_the_field_says) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh mesh = culled_mesh(field, 1, 1);
    for (std::size_t c = 0; c < mesh.cells.cells.size(); ++c) {
        const Cell& cell = mesh.cells.cells[c];
        int inside = 0, outside = 0;
        for (const std::uint32_t v : cell) {
            inside += length(mesh.points()[v]) < 5 - 0.02;
            outside += length(mesh.points()[v]) > 5 + 0.02;
        }
        if (inside > 0 && outside == 0) {
            EXPECT_EQ(mesh.regions[c], 1);
        }
        if (outside == 4) {
            EXPECT_EQ(mesh.regions[c], 0);
        }
    }
}

TEST(Cull, sides_name_the_region_of_every_point_or_the_interface) {
    const AnalyticField field({ball({}, 5)}, 6);
    const CulledMesh mesh = culled_mesh(field, 1, 1);
    ASSERT_EQ(mesh.memberships.size(), mesh.points().size());
    for (std::size_t n = 0; n < mesh.memberships.size(); ++n) {
        const double distance = length(mesh.points()[n]) - 5;
        const VertexMembership& side = mesh.memberships[n];
        EXPECT_EQ(side.off_interfaces(), std::abs(distance) > 0.02);
        EXPECT_EQ(mesh.registry.table().members[side.interior_of].size(), distance < -0.02 ? 1u : 0u);
        EXPECT_EQ(mesh.registry.table().members[side.closure_of].size(), distance <= 0.02 ? 1u : 0u);
    }
}

// Where edges are short a surface at the tolerance's distance is far.
TEST(Cull, sides_go_by_the_shortest_edge_where_asked) {
    const AnalyticField field({ball({}, 5)}, 6);
    CulledMesh mesh = culled_mesh(field, 1, 1);
    std::vector<double> shortest(mesh.points().size(), 1e9);
    for (const Cell& cell : mesh.cells.cells) {
        for (const std::uint32_t a : cell) {
            for (const std::uint32_t b : cell) {
                if (a != b) shortest[a] = std::min(shortest[a], length(mesh.points()[a] - mesh.points()[b]));
            }
        }
    }
    std::size_t nearer = 0;
    for (const double share : {0.05, 0.5}) {
        mesh.memberships.clear();
        mesh.update(field, 1, {0.9, share});
        for (std::size_t n = 0; n < mesh.memberships.size(); ++n) {
            const double distance = std::abs(length(mesh.points()[n]) - 5);
            if (std::abs(distance - std::min(0.9, share * shortest[n])) < 1e-9) continue;
            EXPECT_EQ(mesh.memberships[n].off_interfaces(), distance > std::min(0.9, share * shortest[n]));
            nearer += distance < 0.9 && mesh.memberships[n].off_interfaces();
        }
    }
    EXPECT_GT(nearer, 10u);
}

// A vertex on one structure's surface lies on one side of every other one.
TEST(Cull, sides_tell_structures_that_overlap_apart) {
    const AnalyticField field({ball({-2, 0, 0}, 4), ball({2, 0, 0}, 4)}, 8);
    const CulledMesh mesh = culled_mesh(field, 2, 1);
    const RegionTable& table = mesh.registry.table();
    std::size_t on_one = 0;
    for (std::size_t n = 0; n < mesh.memberships.size(); ++n) {
        const VertexMembership& side = mesh.memberships[n];
        for (std::uint32_t s = 0; s < 2; ++s) {
            const double distance = length(mesh.points()[n] - Vec3{s == 0 ? -2.0 : 2.0, 0, 0}) - 4;
            EXPECT_EQ(table.contains(side.interior_of, s), distance < -0.02);
            EXPECT_EQ(table.contains(side.closure_of, s), distance <= 0.02);
        }
        on_one += !side.off_interfaces();
    }
    EXPECT_GT(on_one, 100u);
    // Deep in the first one, on the second one's surface, against outside both: the first one's runs between.
    RegionRegistry registry;
    const Region first = registry.intern({0}), both = registry.intern({0, 1});
    EXPECT_EQ(parted_by(registry.table(), {first, both, 0}, {0, 0, 1}), 0u);
    EXPECT_EQ(parted_by(registry.table(), {first, both, 0}, {both, both, 1}), std::nullopt);
}

// Structures that exclude each other: a vertex on the surface of one of them is on no third one's.
TEST(Cull, sides_of_a_partition_know_whose_surface_a_vertex_is_on) {
    const AnalyticField field({ball({-4, 0, 0}, 5), ball({4, 0, 0}, 5), ball({0, 5, 0}, 5)}, 12, true);
    const double tolerance = 0.02;
    const CulledMesh mesh = culled_mesh(field, 3, 1);
    const RegionTable& table = mesh.registry.table();
    std::size_t of_one = 0, of_several = 0;
    for (std::size_t n = 0; n < mesh.memberships.size(); ++n) {
        const VertexMembership& side = mesh.memberships[n];
        if (side.off_interfaces()) continue;
        const Vec3 p = mesh.points()[n];
        for (std::uint32_t s = 0; s < 3; ++s) {
            const bool touches = field.value(s, p) <= tolerance;
            EXPECT_EQ(table.contains(side.closure_of, s), touches);
            EXPECT_EQ(allows(table, side, std::vector<std::uint32_t>{s}), touches);
            if (!touches) {
                EXPECT_LE(side.depth_mm, field.value(s, p));
            }
        }
        ++(table.members[side.closure_of].size() > 1 ? of_several : of_one);
    }
    EXPECT_GT(of_one, 300u);
    EXPECT_GT(of_several, 30u);
}

TEST(Cull, only_the_chosen_cells_are_decided) {
    const AnalyticField field({ball({}, 5)}, 6);
    CulledMesh mesh = culled_mesh(field, 1, 1);
    std::vector<Region> regions(mesh.regions.size(), 7), expected = regions;
    std::vector<std::uint32_t> chosen;
    for (std::uint32_t c = 1; c < regions.size(); c += 3) {
        chosen.push_back(c);
        expected[c] = mesh.regions[c];
    }
    RunContext context;
    const CullStats stats = cull({mesh.points(), mesh.cells.cells, chosen}, mesh.memberships, field, 1,
                                 regions, mesh.registry, context);
    EXPECT_EQ(regions, expected);
    EXPECT_EQ(stats.decided, chosen.size());
    EXPECT_EQ(stats.culled, static_cast<std::uint64_t>(std::count(regions.begin(), regions.end(), 0)));
}

TEST(Cull, same_regions_for_any_number_of_threads) {
    const AnalyticField field({ball({-2, 0, 0}, 4), ball({2, 0, 0}, 4), ball({0, 3, 0}, 3)}, 8);
    const CulledMesh one = culled_mesh(field, 3, 0.6, 1);
    EXPECT_GT(one.regions.size(), 10000u);
    for (const int threads : {2, 7}) {
        const CulledMesh several = culled_mesh(field, 3, 0.6, threads);
        EXPECT_EQ(several.regions, one.regions);
        for (std::size_t v = 0; v < one.memberships.size(); ++v) {
            ASSERT_EQ(several.memberships[v].interior_of, one.memberships[v].interior_of);
            ASSERT_EQ(several.memberships[v].closure_of, one.memberships[v].closure_of);
        }
        EXPECT_EQ(several.registry.table().members, one.registry.table().members);
    }
}

}  // namespace
}  // namespace anatomesh::cull_test
