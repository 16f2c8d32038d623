#include "anatomesh/improve/surgery/repair_section_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <random>
#include <utility>

#include "anatomesh/geom/predicates.h"
#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::repair_section_patch_test {
namespace {

constexpr int width = 8, height = 6;
constexpr double any_shape = 1e-3, wall = 3, slice = 3;

// A structure, drawn in the slice z = 3 up to x = 3, or from x = `back` on, and what is beside it: cells of a
// grid, the free vertices of which are shaken, so that the slice's plane passes through them.
struct Block {
    TetMesh mesh = testing::brick_mesh({width, width, height}, [](int, int, int) { return Region{1}; });
    RegionTable table{{{}, {0}}};
    std::vector<std::uint32_t> neighbors, slice_of;
    std::vector<std::uint8_t> fixed;
    std::vector<VertexPair> contour;
    std::vector<Plane> planes{make_plane({0, 0, slice}, {0, 0, 1})};
    std::vector<double> weights{1.0 / (wall * width)};
    ContourOwners owners;
    double back;
    fixtures::AnalyticField field{{[this](Vec3 p) { return std::max(p.x - wall, back - p.x); }}, 10};
    PatchRepairStats stats;

    // `inside`: of the middles of the grid's cubes. `also`: a vertex that a contour of another slice has.
    explicit Block(const std::function<bool(Vec3)>& inside, unsigned seed = 1, double shaken = 0.25,
                   std::optional<Vec3> also = std::nullopt, double from = -10)
        : back(from) {
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 p;
            for (const std::uint32_t v : mesh.cells[c]) p += 0.25 * mesh.points[v];
            const auto middle = [](double x) { return std::floor(x) + 0.5; };
            mesh.regions[c] = inside({middle(p.x), middle(p.y), middle(p.z)}) ? 1 : 0;
        }
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> shift(-shaken, shaken);
        std::vector<std::array<std::uint32_t, 2>> vertices;
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        std::array<std::uint32_t, 2> last{no_cell, no_cell};
        for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
            Vec3& p = mesh.points[v];
            const bool rim =
                p.x == 0 || p.x == width || p.y == 0 || p.y == width || p.z == 0 || p.z == height;
            const bool on = (p.x == wall || p.x == back) && p.z == slice;
            slice_of.push_back(on ? 0 : no_slice);
            fixed.push_back(rim || on);
            if (also && p == *also) {
                vertices.push_back({v, 0});
                fixed.back() = 1;
            }
            if (!fixed.back()) p = p + Vec3{shift(random), shift(random), shift(random)};
            if (!on) continue;
            vertices.push_back({v, 0});
            std::uint32_t& before = last[p.x == wall];
            if (before != no_cell) {
                subsegments.push_back({before, v, 0});
                contour.push_back({before, v});
            }
            before = v;
        }
        std::sort(contour.begin(), contour.end());
        owners = ContourOwners(vertices, mesh.points.size(), subsegments);
    }

    // With the share of the slice that is wrong before and after.
    std::array<double, 2> repair_patch(
        const ImproveCells& improve = [](auto) { return std::vector<std::uint32_t>{}; },
        double least_sine = any_shape) {
        EditMesh edited(std::move(mesh), neighbors);
        MeshImprovementOptions options;
        options.spike_mm = 10;
        options.max_radius_edge = options.last_radius_edge = 100;
        EditContext edit(edited, fixed, contour, field, 1, options);
        edit.table = &table;
        const DrawnSlices drawn{&table, slice_of, &owners, planes, {}, weights, 1e-9};
        SectionAreas areas(edit, drawn);
        const auto wrong = [&] {
            areas.sum_cuts(edited.alive_cells());
            return areas.sums()[0];
        };
        std::array<double, 2> shares{wrong(), 0};
        stats = repair_section_patch(edit, drawn, least_sine, improve, {});
        shares[1] = wrong();
        mesh = std::move(edited).take(neighbors);
        return shares;
    }

    SurfaceTopology topology() const { return surface_topology(structure_surface(mesh, table, 0)); }

    // A closed manifold with the contour on it.
    bool is_sound() const {
        std::vector<VertexPair> edges;
        for (const Triangle& facet : structure_surface(mesh, table, 0)) {
            for (std::size_t k = 0; k < 3; ++k)
                edges.push_back(
                    {std::min(facet[k], facet[(k + 1) % 3]), std::max(facet[k], facet[(k + 1) % 3])});
        }
        std::sort(edges.begin(), edges.end());
        return topology().closed_manifold() &&
               std::all_of(contour.begin(), contour.end(), [&](const VertexPair& subsegment) {
                   return std::binary_search(edges.begin(), edges.end(), subsegment);
               });
    }

    void expect_sound() const {
        for (const Cell& v : mesh.cells) {
            ASSERT_GT(orient3d(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]),
                      0);
        }
        EXPECT_EQ(neighbors, cell_neighbors(mesh.cells, mesh.points.size()));
        EXPECT_TRUE(is_sound());
    }
};

bool left_of_wall(Vec3 p) {
    return p.x < wall;
}

// A hook that hangs through the slice from above, three cubes beside the wall.
bool in_hook(Vec3 p) {
    return p.y > 3 && p.y < 5 &&
           ((p.z > 4 && p.z < 5 && p.x < 6) || (p.x > 5 && p.x < 6 && p.z > 2 && p.z < 5));
}

TEST(RepairSectionPatch, a_cut_that_is_as_drawn_is_left_as_it_is) {
    Block block(left_of_wall);
    const TetMesh before = block.mesh;
    EXPECT_EQ(block.repair_patch(), (std::array{0.0, 0.0}));
    EXPECT_EQ(block.stats.patches_found, 0u);
    EXPECT_EQ(block.mesh.points, before.points);
    EXPECT_EQ(block.mesh.regions, before.regions);
}

// What comes of these cubes by ten ways to shake them, `also` as a block has it: nothing of the cut is wrong
// any more.
void expect_repaired(const std::function<bool(Vec3)>& inside, std::optional<Vec3> also, std::int64_t genus,
                     std::uint32_t shells) {
    for (unsigned seed = 0; seed < 10; ++seed) {
        Block block(inside, seed, 0.25, also);
        ASSERT_EQ(block.topology().components, 1u);
        ASSERT_EQ(block.topology().genus, genus);
        const auto [before, after] = block.repair_patch();
        EXPECT_GT(before, 0.02);
        EXPECT_LT(after, 1e-3);
        block.expect_sound();
        EXPECT_EQ(block.topology().components, shells);
        EXPECT_EQ(block.topology().genus, 0);
    }
}

bool wall_with_hook(Vec3 p) {
    return left_of_wall(p) || in_hook(p);
}

TEST(RepairSectionPatch, what_hangs_through_a_slice_beside_what_is_drawn_is_cut_through) {
    expect_repaired(wall_with_hook, Vec3{6, 4, 2}, 0, 2);  // the slice has nothing between them
}

TEST(RepairSectionPatch, what_is_cut_off_and_no_contour_has_goes_too) {
    expect_repaired(wall_with_hook, std::nullopt, 0, 1);
}

TEST(RepairSectionPatch, a_handle_round_a_slice_goes) {
    const auto and_back = [](Vec3 p) {
        return wall_with_hook(p) || (p.y > 3 && p.y < 5 && p.z > 1 && p.z < 2 && p.x < 6);
    };
    expect_repaired(and_back, std::nullopt, 1, 1);
}

TEST(RepairSectionPatch, a_pit_through_what_is_drawn_is_filled_at_the_slice) {
    const auto with_pit = [](Vec3 p) {
        return left_of_wall(p) && p.z > 1 && !(p.x > 1 && p.x < 2 && p.y > 3 && p.y < 4 && p.z < 5);
    };
    expect_repaired(with_pit, Vec3{2, 4, 4}, 0, 2);  // what is left of the pit over the slice is a void
}

// Between two parts, which the slice has as one.
TEST(RepairSectionPatch, a_gap_through_what_is_drawn_is_bridged_at_the_slice) {
    for (unsigned seed = 0; seed < 3; ++seed) {
        Block block([](Vec3 p) { return left_of_wall(p) && p.x > 1 && p.z > 1 && !(p.y > 3 && p.y < 5); },
                    seed, 0.25, std::nullopt, 1);
        ASSERT_EQ(block.topology().components, 2u);
        const auto [before, after] = block.repair_patch();
        EXPECT_GT(before, 0.1);
        EXPECT_LT(after, 1e-3);
        block.expect_sound();
        EXPECT_EQ(block.topology().components, 1u);
        EXPECT_EQ(block.topology().genus, 0);
    }
}

// It would be a handle: the two legs are one over the slice.
TEST(RepairSectionPatch, what_is_joined_beside_a_slice_is_not_joined_twice) {
    for (unsigned seed = 0; seed < 3; ++seed) {
        Block block(
            [](Vec3 p) { return left_of_wall(p) && p.x > 1 && p.z > 1 && !(p.y > 3 && p.y < 5 && p.z < 5); },
            seed, 0.25, std::nullopt, 1);
        const auto [before, after] = block.repair_patch();
        EXPECT_GT(before, 0.1);
        EXPECT_EQ(before, after);
        EXPECT_EQ(block.topology().components, 1u);
        EXPECT_EQ(block.topology().genus, 0);
    }
}

// More than a spurious component: it stays, and the cut as it is.
TEST(RepairSectionPatch, much_that_no_contour_has_is_not_cut_off) {
    for (unsigned seed = 0; seed < 3; ++seed) {
        Block block(
            [](Vec3 p) {
                return wall_with_hook(p) || (p.x > 5 && p.x < 7 && p.y > 1 && p.y < 7 && p.z < 2 && p.z > 0);
            },
            seed);
        const auto [before, after] = block.repair_patch();
        EXPECT_GT(before, 0.05);
        EXPECT_EQ(before, after);
        EXPECT_EQ(block.topology().components, 1u);
    }
}

// Cubes that rest on the slice beside the contour, with the facets in it, and such that hang through it at
// the contour: of both the contour's own cells stay.
TEST(RepairSectionPatch, what_begins_at_the_contour_goes_and_the_contour_stays) {
    int tried = 0;
    for (unsigned seed = 0; seed < 20; ++seed) {
        std::mt19937 random(seed);
        std::vector<int> from(width, 9), to(width, 0);
        for (int y = 1; y < width - 1; ++y) {
            if (random() % 2) continue;
            from[static_cast<std::size_t>(y)] = 3;
            to[static_cast<std::size_t>(y)] = 3 + static_cast<int>(1 + random() % 2);
        }
        const auto rests = [&](Vec3 p) {
            const auto y = static_cast<std::size_t>(p.y);
            return p.x > wall && p.x < wall + 1 && p.z > from[y] && p.z < to[y];
        };
        Block block([&](Vec3 p) { return left_of_wall(p) || rests(p); }, seed, 0.2);
        if (block.topology().components != 1 || !block.is_sound()) continue;
        ++tried;
        const auto [before, after] = block.repair_patch();
        EXPECT_LE(after, std::max(0.5 * before, 1e-3));
        block.expect_sound();
        EXPECT_EQ(block.topology().components, 1u);
        EXPECT_EQ(block.topology().genus, 0);
    }
    EXPECT_GT(tried, 5);
}

// Any cubes beside the wall, as long as the surface is a manifold: what goes may meet the other side in
// vertices and edges alone.
TEST(RepairSectionPatch, patches_among_any_cubes_go) {
    double all_before = 0, all_after = 0;
    int tried = 0;
    for (unsigned seed = 0; seed < 400; ++seed) {
        std::mt19937 random(seed);
        std::array<bool, 3 * 4 * 4> in{};
        for (bool& cube : in) cube = random() % 9 == 0;
        Block block(
            [&](Vec3 p) {
                if (left_of_wall(p)) return true;
                const auto i = static_cast<int>(p.x) - 3, j = static_cast<int>(p.y) - 2,
                           k = static_cast<int>(p.z) - 1;
                return i < 3 && j >= 0 && j < 4 && k >= 0 && k < 4 &&
                       in[static_cast<std::size_t>(i + 3 * j + 12 * k)];
            },
            seed, 0.15);
        if (!block.is_sound()) continue;
        ++tried;
        const auto [before, after] = block.repair_patch();
        EXPECT_LE(after, std::max(before, much_of_cut));
        all_before += before;
        all_after += after;
        block.expect_sound();
    }
    EXPECT_GT(tried, 10);
    EXPECT_LT(all_after, 0.05 * all_before);
}

TEST(RepairSectionPatch, all_is_as_it_was_where_cells_are_too_flat) {
    Block block(wall_with_hook, 1, 0.25, Vec3{6, 4, 2});
    const TetMesh before = block.mesh;
    const auto [wrong, after] = block.repair_patch([](auto) { return std::vector<std::uint32_t>{}; }, 0.99);
    EXPECT_EQ(wrong, after);
    EXPECT_EQ(block.stats.patches_repaired, 0u);
    EXPECT_GT(block.stats.patches_found, 0u);
    EXPECT_EQ(block.mesh.cells, before.cells);
    EXPECT_EQ(block.mesh.regions, before.regions);
}

TEST(RepairSectionPatch, the_shapes_of_what_changed_are_worked_on) {
    Block block(wall_with_hook, 1, 0.25, Vec3{6, 4, 2});
    std::size_t asked = 0;
    const auto [before, after] = block.repair_patch([&](std::vector<std::uint32_t> cells) {
        asked += cells.size();
        return std::vector<std::uint32_t>{};
    });
    EXPECT_GT(before, after);
    EXPECT_GT(asked, 0u);
    EXPECT_FALSE(block.stats.changed.empty());
}

// Planes at any height through meshes whose cells are on one side or the other: nearly all sections at the
// surface are wrong, and most patches can't be repaired.
TEST(RepairSectionPatch, surfaces_stay_manifolds_and_no_cut_gets_worse_whatever_is_repaired) {
    std::uint64_t repaired = 0;
    std::vector<fixtures::LabelledCase> cases = fixtures::labelled_cases();
    for (std::size_t n = 1; n < cases.size(); n += 3) {  // shell, overlapping balls, random tori and overlaps
        fixtures::LabelledCase& made = cases[n];
        const std::vector<Plane> planes{make_plane({0, 0, 0.3}, {0, 0, 1}),
                                        make_plane({0, 0, -2.2}, {0, 0, 1})};
        const std::vector<double> weights(planes.size() * made.structures, 0.01);
        const std::vector<std::uint32_t> slice_of(made.mesh.points.size(), no_slice);
        const ContourOwners owners({}, made.mesh.points.size());
        const TetMesh before = made.mesh;
        std::vector<std::uint32_t> neighbors = cell_neighbors(made.mesh.cells, made.mesh.points.size());
        EditMesh edited(std::move(made.mesh), neighbors);
        MeshImprovementOptions options;
        options.spike_mm = 10;
        options.max_radius_edge = options.last_radius_edge = 100;
        EditContext edit(edited, made.fixed, {}, made.field, made.structures, options);
        edit.table = &made.regions;
        const DrawnSlices drawn{&made.regions, slice_of, &owners, planes, {}, weights, 1e-9};
        SectionAreas areas(edit, drawn);
        const auto sums = [&] {
            areas.sum_cuts(edited.alive_cells());
            return std::vector<double>(areas.sums().begin(), areas.sums().end());
        };
        const std::vector<double> wrong = sums();
        const PatchRepairStats stats = repair_section_patch(
            edit, drawn, any_shape, [](auto) { return std::vector<std::uint32_t>{}; }, {});
        const std::vector<double> after = sums();
        repaired += stats.patches_repaired;
        for (std::size_t cut = 0; cut < wrong.size(); ++cut)
            EXPECT_LE(after[cut], std::max(wrong[cut], much_of_cut));
        made.mesh = std::move(edited).take(neighbors);
        fixtures::expect_sound_mesh(made.mesh, before);
        for (std::uint32_t s = 0; s < made.structures; ++s)
            EXPECT_TRUE(surface_topology(structure_surface(made.mesh, made.regions, s)).closed_manifold())
                << made.name;
    }
    EXPECT_GT(repaired, 5u);
}

}  // namespace
}  // namespace anatomesh::repair_section_patch_test
