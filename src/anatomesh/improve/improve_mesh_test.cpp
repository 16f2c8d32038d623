#include "anatomesh/improve/improve_mesh.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh::improve_mesh_test {
namespace {

using namespace fixtures;

struct Improved {
    TetMesh mesh;
    std::vector<std::uint8_t> fixed;
    MeshImprovementStats stats;
};

std::vector<std::uint32_t> neighbors_of(const TetMesh& mesh) {
    return cell_neighbors(mesh.cells, mesh.points.size());
}

Improved improved(const LabelledCase& c, std::span<const VertexPair> edges = {},
                  MeshImprovementOptions options = {}, int threads = 1) {
    Improved result{c.mesh, c.fixed, {}};
    RunContext context;
    context.threads = threads;
    std::vector<std::uint32_t> neighbors = neighbors_of(c.mesh);
    result.stats = improve_mesh(result.mesh, neighbors, {result.fixed, edges}, c.field, c.structures,
                                {&c.regions, {}}, options, context);
    EXPECT_EQ(neighbors, neighbors_of(result.mesh));
    return result;
}

// Inside, with an angle below the target.
std::size_t bad_cells(const TetMesh& mesh) {
    const double target = std::sin(MeshImprovementOptions{}.target_degrees * std::numbers::pi / 180);
    std::size_t count = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const Cell& v = mesh.cells[c];
        count += mesh.regions[c] != 0 && least_sine(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]],
                                                    mesh.points[v[3]]) < target;
    }
    return count;
}

TEST(ImproveMesh, keeps_surfaces_volume_and_fixed_vertices_and_makes_nothing_worse) {
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        const Improved done = improved(c);
        expect_sound_mesh(done.mesh, c.mesh);
        expect_same_surfaces(done.mesh, c.mesh, c.regions, c.structures);
        ASSERT_EQ(done.fixed.size(), done.mesh.points.size());
        for (std::size_t v = 0; v < c.fixed.size(); ++v) {
            ASSERT_EQ(done.fixed[v], c.fixed[v]);
            ASSERT_TRUE(!c.fixed[v] || done.mesh.points[v] == c.mesh.points[v]);
        }
        for (std::uint32_t s = 0; s < c.structures; ++s) {
            const auto before = on_surface(c.mesh, c.regions, s), after = on_surface(done.mesh, c.regions, s);
            for (std::size_t v = 0; v < c.fixed.size(); ++v) {
                const bool near =
                    std::abs(c.field.value(s, c.mesh.points[v])) <= MeshImprovementOptions{}.least_spike_mm;
                ASSERT_TRUE(!c.fixed[v] || before[v] == after[v] || (before[v] && !near));
            }
        }
        EXPECT_GE(worst_sine(done.mesh), worst_sine(c.mesh));
        const MeshImprovementOptions bounds;
        EXPECT_LE(worst_ratio(done.mesh),
                  std::max(bounds.last_radius_edge, worst_ratio(c.mesh)) * (1 + 1e-9));
        MeshImprovementOptions strict;
        strict.last_radius_edge = strict.max_radius_edge;
        EXPECT_LE(worst_ratio(improved(c, {}, strict).mesh),
                  std::max(strict.max_radius_edge, worst_ratio(c.mesh)) * (1 + 1e-9));
        EXPECT_LE(done.stats.bad_after, done.stats.bad_before);
        EXPECT_EQ(done.stats.bad_after, bad_cells(done.mesh));
    }
}

// Most of the bad cells of a mesh whose vertices are free can be repaired.
TEST(ImproveMesh, reaches_the_target_where_vertices_are_free) {
    const LabelledCase c = sampled_case("ball", AnalyticField({ball({}, 6)}, 7), 1, 1'000'000);
    const Improved done = improved(c);
    EXPECT_GT(done.stats.bad_before, 10u);
    EXPECT_EQ(done.stats.bad_after, 0u);
    EXPECT_GE(worst_sine(done.mesh), std::sin(15 * 3.14159265358979 / 180));
    const auto off_interface = [&](const TetMesh& mesh) {
        std::size_t off = 0;
        const auto on = on_surface(mesh, c.regions, 0);
        for (std::size_t v = 0; v < on.size(); ++v)
            off += on[v] && c.field.interface_distance(mesh.points[v]) > 0.05;
        return off;
    };
    EXPECT_LE(off_interface(done.mesh), off_interface(c.mesh));
}

// Speculation on several threads leaves out what would fail, and nothing else.
TEST(ImproveMesh, several_threads_make_the_same_mesh_by_the_same_operations) {
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        const Improved one = improved(c);
        for (const int threads : {2, 3}) {
            const Improved several = improved(c, {}, {}, threads);
            EXPECT_EQ(one.mesh.points, several.mesh.points);
            EXPECT_EQ(one.mesh.cells, several.mesh.cells);
            EXPECT_EQ(one.mesh.regions, several.mesh.regions);
            EXPECT_EQ(one.stats.tries, several.stats.tries);
            EXPECT_EQ(one.stats.operations.edges_removed, several.stats.operations.edges_removed);
            EXPECT_EQ(one.stats.operations.vertices_moved, several.stats.operations.vertices_moved);
            EXPECT_EQ(one.stats.operations.surface_edges_smoothed,
                      several.stats.operations.surface_edges_smoothed);
        }
    }
}

TEST(ImproveMesh, repeats_bit_for_bit_and_leaves_what_is_good) {
    const LabelledCase c = random_case("random", AnalyticField({ball({}, 7)}, 9), 1, 7);
    const Improved first = improved(c), second = improved(c);
    EXPECT_EQ(first.mesh.points, second.mesh.points);
    EXPECT_EQ(first.mesh.cells, second.mesh.cells);
    EXPECT_EQ(first.mesh.regions, second.mesh.regions);
    MeshImprovementOptions easy;
    easy.target_degrees = 0;
    easy.flip_gain_degrees = 900;
    easy.last_radius_edge = 1e9;
    easy.ratio_passes = 0;
    easy.least_spike_mm = 1e9;
    const Improved untouched = improved(c, {}, easy);
    EXPECT_EQ(untouched.mesh.points, c.mesh.points);
    EXPECT_EQ(untouched.mesh.cells, c.mesh.cells);
    EXPECT_EQ(untouched.stats.tries, 0u);
}

// The mean angle between neighbouring facets of a structure's surface, in degrees.
double mean_angle(const TetMesh& mesh, const RegionTable& regions) {
    std::map<VertexPair, Vec3> waiting;
    double sum = 0;
    std::size_t count = 0;
    for (const Triangle& f : structure_surface(mesh, regions, 0)) {
        const Vec3 p = mesh.points[f[0]],
                   normal = normalized(cross(mesh.points[f[1]] - p, mesh.points[f[2]] - p));
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = f[i], b = f[(i + 1) % 3];
            const auto [other, is_first] = waiting.try_emplace({std::min(a, b), std::max(a, b)}, normal);
            if (is_first) continue;
            sum += std::atan2(length(cross(normal, other->second)), dot(normal, other->second));
            ++count;
        }
    }
    return sum / static_cast<double>(count) * 180 / 3.14159265358979;
}

// Ratios above the bound buy angles of at least 10 degrees.
TEST(ImproveMesh, ratios_rise_above_the_bound_only_where_angles_below_10_degrees_go) {
    std::size_t bought = 0;
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        MeshImprovementOptions strict;
        strict.last_radius_edge = strict.max_radius_edge;
        const auto below = [](const TetMesh& mesh) {
            std::size_t count = 0;
            for (std::size_t n = 0; n < mesh.cells.size(); ++n)
                count += mesh.regions[n] != 0 &&
                         sine_of(mesh, mesh.cells[n]) < std::sin(10 * 3.14159265358979 / 180);
            return count;
        };
        const std::size_t left = below(improved(c, {}, strict).mesh), after = below(improved(c).mesh);
        EXPECT_LE(after, left);
        bought += left - after;
    }
    EXPECT_GT(bought, 0u);
}

// Most cells above the bound that angles leave are lowered to it, at no angle below the least there was or
// the target.
TEST(ImproveMesh, lowers_ratios_above_the_bound_at_no_angle_below_the_target) {
    const double bound = MeshImprovementOptions{}.max_radius_edge,
                 target = MeshImprovementOptions{}.target_degrees;
    const auto above = [&](const TetMesh& mesh) {
        std::size_t count = 0;
        for (std::size_t n = 0; n < mesh.cells.size(); ++n) {
            const Cell& v = mesh.cells[n];
            count += mesh.regions[n] != 0 && radius_edge_ratio(mesh.points[v[0]], mesh.points[v[1]],
                                                               mesh.points[v[2]], mesh.points[v[3]]) > bound;
        }
        return count;
    };
    std::size_t left = 0, after = 0;
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        MeshImprovementOptions angles_alone;
        angles_alone.ratio_passes = 0;
        const Improved before = improved(c, {}, angles_alone), done = improved(c);
        EXPECT_LE(above(done.mesh), above(before.mesh));
        EXPECT_EQ(done.stats.operations.cells_relabelled,
                  before.stats.operations.cells_relabelled);  // not by giving them away
        EXPECT_GE(worst_sine(done.mesh),
                  std::min(worst_sine(before.mesh), std::sin(target * std::numbers::pi / 180)));
        left += above(before.mesh);
        after += above(done.mesh);
    }
    EXPECT_GT(left, 20u);
    EXPECT_LT(2 * after, left);
}

// Flips of a surface's edges make it smoother; no angle inside falls below the target for it, and edges that
// are fixed stay.
TEST(ImproveMesh, flips_edges_of_surfaces_for_smaller_angles_between_facets) {
    for (const LabelledCase& c :
         {sampled_case("torus", AnalyticField({torus(6, 2.5)}, 9), 1, 1'000'000),
          sampled_case("torus of fixed vertices", AnalyticField({torus(6, 2.5)}, 9), 1, 1)}) {
        SCOPED_TRACE(c.name);
        MeshImprovementOptions never;
        never.flip_gain_degrees = 900;
        const Improved flipped = improved(c), not_flipped = improved(c, {}, never);
        EXPECT_EQ(not_flipped.stats.operations.surface_edges_smoothed, 0u);
        EXPECT_GT(flipped.stats.operations.surface_edges_smoothed, 10u);
        EXPECT_LT(mean_angle(flipped.mesh, c.regions), 0.97 * mean_angle(not_flipped.mesh, c.regions));
        EXPECT_LE(flipped.stats.bad_after, not_flipped.stats.bad_after);
        expect_sound_mesh(flipped.mesh, c.mesh);
        expect_same_surfaces(flipped.mesh, c.mesh, c.regions, 1);
    }
}

// A cell beside the surface, in the region beyond it, whose fourth vertex is free and off the surface.
std::uint32_t cell_beyond_the_surface(const TetMesh& mesh, const std::vector<std::uint8_t>& on, Region region,
                                      std::uint32_t from) {
    const std::vector<std::uint32_t> neighbors = cell_neighbors(mesh.cells, mesh.points.size());
    for (std::uint32_t c = from; c < mesh.cells.size(); ++c) {
        if (mesh.regions[c] != region || sine_of(mesh, mesh.cells[c]) < 0.4) continue;
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t n = neighbors[4 * c + i];
            if (n != no_cell && mesh.regions[n] != region && !on[mesh.cells[c][i]]) return c;
        }
    }
    return no_cell;
}

// Spikes and pits of one cell, made on a ball's surface, are taken off again.
TEST(ImproveMesh, takes_spikes_and_pits_of_one_cell_off_the_surface) {
    LabelledCase c = sampled_case("ball", AnalyticField({ball({}, 6)}, 7), 1, 1'000'000);
    const auto on = on_surface(c.mesh, c.regions, 0);
    const Region inside = 1;
    std::size_t made = 0;
    std::vector<std::uint8_t> touched(c.mesh.points.size(), 0);
    for (const Region region : {Region{0}, inside}) {
        std::uint32_t cell = 0;
        for (int n = 0; n < 200; ++n) {
            cell = cell_beyond_the_surface(c.mesh, on, region, cell + 1);
            if (cell == no_cell) break;
            const Cell& v = c.mesh.cells[cell];
            if (std::any_of(v.begin(), v.end(), [&](std::uint32_t p) { return touched[p] != 0; })) continue;
            for (const std::uint32_t p : v) touched[p] = 1;
            c.mesh.regions[cell] = region == 0 ? inside : Region{0};
            ++made;
        }
    }
    ASSERT_GT(made, 4u);
    const Improved done = improved(c);
    EXPECT_GE(done.stats.surgeries.cell_spikes_removed, made * 3 / 4);
    const auto after = on_surface(done.mesh, c.regions, 0);
    for (std::size_t v = 0; v < on.size(); ++v) {
        if (on[v] || !after[v]) continue;
        EXPECT_LT(c.field.interface_distance(done.mesh.points[v]), 0.1) << v;
    }
}

// A nearly flat cell in a plane wall between two prisms that lie on the wall, one on either side, their sides
// cut along such diagonals that neither has cells with the other one's diagonal in the wall (E. Schoenhardt,
// Math. Ann. 98, 1928): no flip helps, there has to be a vertex within. All corners are fixed.
TEST(ImproveMesh, a_flat_cell_in_a_wall_between_fixed_corners_gets_a_vertex_beside_it) {
    LabelledCase c{"wall",
                   AnalyticField({[](Vec3 p) { return -p.x; }, [](Vec3 p) { return p.x; }}, 3),
                   2,
                   {},
                   RegionTable{{{}, {0}, {1}}},
                   {}};
    // The wall's corners in turn, then the ridges of the prisms.
    c.mesh.points = {{0, 0, 0},
                     {-0.035726, 0.996187, 0.079595},
                     {-0.032874, 0.916643, 1.076422},
                     {0.002853, -0.079544, 0.996827},
                     {0.909854431, -0.413398283, -0.035591756},
                     {0.912707431, -0.492942283, 0.961235244},
                     {-1.543916, 1.191465, 0.099494},
                     {-1.541063, 1.111921, 1.096321}};
    const auto add = [&](Cell cell, Region region) {
        const auto& p = c.mesh.points;
        if (signed_volume(p[cell[0]], p[cell[1]], p[cell[2]], p[cell[3]]) < 0) std::swap(cell[2], cell[3]);
        c.mesh.cells.push_back(cell);
        c.mesh.regions.push_back(region);
    };
    for (const Cell& cell : {Cell{4, 1, 0, 3}, Cell{4, 1, 3, 5}, Cell{5, 2, 1, 3}, Cell{0, 1, 2, 3}})
        add(cell, 1);
    for (const Cell& cell : {Cell{0, 2, 1, 6}, Cell{0, 7, 2, 6}, Cell{0, 7, 3, 2}}) add(cell, 2);
    c.fixed.assign(c.mesh.points.size(), 1);
    const Improved done = improved(c);
    expect_sound_mesh(done.mesh, c.mesh);
    EXPECT_LT(done.stats.worst_before_degrees, 1e-3);
    EXPECT_GE(done.stats.worst_after_degrees, 10);
    EXPECT_EQ(done.stats.operations.vertices_inserted, 1u);
}

// All edges of a surface whose vertices are fixed are kept when asked for.
TEST(ImproveMesh, keeps_fixed_edges_on_the_surface) {
    LabelledCase c = random_case("random", AnalyticField({ball({}, 7)}, 9), 1, 11);
    std::vector<VertexPair> edges;
    for (const Triangle& f : structure_surface(c.mesh, c.regions, 0)) {
        for (std::size_t i = 0; i < 3; ++i) {
            c.fixed[f[i]] = 1;
            edges.push_back({std::min(f[i], f[(i + 1) % 3]), std::max(f[i], f[(i + 1) % 3])});
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    EXPECT_EQ(edges_along(c.mesh, neighbors_of(c.mesh), edges), edges);
    const Improved kept = improved(c, edges);
    EXPECT_GT(kept.stats.operations.edges_removed, 0u);
    EXPECT_EQ(kept.stats.operations.surface_edges_flipped + kept.stats.operations.surface_edges_smoothed, 0u);
    // They, or chains along them with a new vertex that is fixed.
    const auto split =
        std::count(kept.fixed.begin() + static_cast<std::ptrdiff_t>(c.fixed.size()), kept.fixed.end(), 1);
    EXPECT_EQ(edges_along(kept.mesh, neighbors_of(kept.mesh), edges).size(),
              edges.size() + static_cast<std::size_t>(split));
    MeshImprovementOptions loose;
    loose.max_deviation_mm = 10;
    const Improved flipped = improved(c, {}, loose);
    EXPECT_GT(flipped.stats.operations.surface_edges_flipped, 0u);
}

// So many that none is recovered to the surface.
TEST(ImproveMesh, keeps_subsegments_beside_their_surface) {
    constexpr std::size_t every = 10, most_recovered = 40;
    LabelledCase c = random_case("random", AnalyticField({ball({}, 7)}, 9), 1, 11);
    const std::vector<std::uint8_t> surface = on_surface(c.mesh, c.regions, 0);
    std::map<VertexPair, std::array<bool, 2>> sides;
    for (std::size_t n = 0; n < c.mesh.cells.size(); ++n) {
        for (const auto& [i, j] : cell_edges) {
            const std::uint32_t a = c.mesh.cells[n][i], b = c.mesh.cells[n][j];
            if (surface[a] && surface[b])
                sides[{std::min(a, b), std::max(a, b)}][c.mesh.regions[n] != 0] = true;
        }
    }
    std::vector<std::array<std::uint32_t, 3>> subsegments;
    std::size_t found = 0;
    for (const auto& [edge, side] : sides) {
        if (side[0] != side[1] && ++found % every == 0) subsegments.push_back({edge[0], edge[1], 0});
    }
    ASSERT_GT(subsegments.size(), most_recovered);
    std::vector<std::array<std::uint32_t, 2>> owned;
    for (const auto& [a, b, structure] : subsegments) {
        c.fixed[a] = c.fixed[b] = 1;
        owned.push_back({a, structure});
        owned.push_back({b, structure});
    }
    const ContourOwners owners(owned, c.mesh.points.size(), subsegments);
    DrawnSlices drawn;
    drawn.table = &c.regions;
    drawn.owners = &owners;
    drawn.subsegments_beside = subsegments;
    std::vector<std::uint32_t> neighbors = neighbors_of(c.mesh);
    RunContext context;
    const MeshImprovementStats stats =
        improve_mesh(c.mesh, neighbors, {c.fixed, {}}, c.field, 1, drawn, {}, context);
    EXPECT_GT(stats.operations.edges_removed, 0u);
    EXPECT_EQ(stats.surgeries.subsegments_recovered, 0u);
    std::set<VertexPair> edges;
    for (const Cell& cell : c.mesh.cells) {
        for (const auto& [i, j] : cell_edges)
            edges.insert({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
    }
    for (const auto& [a, b, structure] : subsegments) EXPECT_TRUE(edges.contains({a, b})) << a << " " << b;
}

// Beside pairs of vertices that force ill-shaped cells others come out better when those may be the worse for
// it, within bounds.
TEST(ImproveMesh, cells_that_contours_crowd_give_way_to_ill_shaped_ones_beside_them) {
    std::vector<Vec3> pairs;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> at(-4, 4), off(-0.02, 0.02);
    while (pairs.size() < 40) {
        pairs.push_back({at(random), at(random), at(random)});
        pairs.push_back(pairs.back() + Vec3{off(random), off(random), off(random)});
    }
    const LabelledCase c = random_case("random", AnalyticField({ball({}, 7)}, 9), 1, 1, pairs);
    std::vector<std::uint8_t> fixed = c.fixed, constraint_limited(pairs.size(), 1);
    std::fill(fixed.begin(), fixed.begin() + static_cast<std::ptrdiff_t>(pairs.size()), 1);
    const auto ill_shaped_beside = [&](bool spares) {
        TetMesh mesh = c.mesh;
        std::vector<std::uint8_t> held = fixed;
        std::vector<std::uint32_t> neighbors = neighbors_of(mesh);
        DrawnSlices drawn;
        drawn.table = &c.regions;
        if (spares) drawn.constraint_limited = constraint_limited;
        RunContext context;
        improve_mesh(mesh, neighbors, {held, {}}, c.field, 1, drawn, {}, context);
        expect_sound_mesh(mesh, c.mesh);
        EXPECT_GE(worst_sine(mesh), std::min(worst_sine(c.mesh), 0.01));
        drawn.constraint_limited = constraint_limited;
        std::size_t count = 0;
        for (std::size_t n = 0; n < mesh.cells.size(); ++n) {
            const Cell& v = mesh.cells[n];
            if (mesh.regions[n] == 0 || drawn.are_constraint_limited(v)) continue;
            count += sine_of(mesh, v) < std::sin(10 * std::numbers::pi / 180) ||
                     radius_edge_ratio(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]],
                                       mesh.points[v[3]]) > MeshImprovementOptions{}.last_radius_edge;
        }
        return count;
    };
    const std::size_t without = ill_shaped_beside(false);
    EXPECT_GT(without, 10u);
    EXPECT_LE(ill_shaped_beside(true), without / 5);
}

TEST(EdgesAlong, finds_the_chain_of_a_segment_and_nothing_for_one_that_is_missing) {
    const LabelledCase c = sampled_case("box", AnalyticField({ball({}, 3)}, 4), 1);
    std::vector<Triangle> surface = structure_surface(c.mesh, c.regions, 0);
    const auto [a, b, d] = surface[0];
    const VertexPair edge{std::min(a, b), std::max(a, b)};
    EXPECT_EQ(edges_along(c.mesh, neighbors_of(c.mesh), std::vector<VertexPair>{{b, a}, {a, b}}),
              std::vector<VertexPair>{edge});
    std::uint32_t far = a;
    for (const Triangle& f : surface) {
        if (length(c.mesh.points[f[0]] - c.mesh.points[a]) > length(c.mesh.points[far] - c.mesh.points[a]))
            far = f[0];
    }
    EXPECT_TRUE(edges_along(c.mesh, neighbors_of(c.mesh), std::vector<VertexPair>{{a, far}}).empty());
}

TEST(EdgesAlong, finds_what_there_is_of_a_segment_with_a_gap) {
    LabelledCase c = sampled_case("box", AnalyticField({ball({}, 3)}, 4), 1);
    const std::vector<std::uint32_t> neighbors = neighbors_of(c.mesh);
    std::size_t found = 0;
    for (const auto& [a, b, d] : structure_surface(c.mesh, c.regions, 0)) {
        TetMesh mesh = c.mesh;
        const auto beyond = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.push_back(mesh.points[b] + (mesh.points[b] - mesh.points[a]));
        const std::vector<VertexPair> edge{{std::min(a, b), std::max(a, b)}};
        EXPECT_EQ(edges_along(mesh, neighbors, std::vector<VertexPair>{{a, beyond}}), edge);
        EXPECT_EQ(edges_along(mesh, neighbors, std::vector<VertexPair>{{beyond, a}}), edge);
        ++found;
    }
    EXPECT_GT(found, 10u);
}

}  // namespace
}  // namespace anatomesh::improve_mesh_test
