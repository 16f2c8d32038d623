// Laws of the operations for the cells that nothing else helps: giving cells away, new vertices on
// interfaces.
#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/improve/operations/operations.h"
#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/mesh/edit/facets.h"

namespace anatomesh::last_operations_test {
namespace {

using namespace fixtures;

std::vector<std::uint32_t> neighbors_of(const TetMesh& mesh) {
    return cell_neighbors(mesh.cells, mesh.points.size());
}

// A case on an edit context.
struct EditFixture {
    explicit EditFixture(const LabelledCase& c, std::span<const VertexPair> edges = {})
        : fixed(c.fixed),
          mesh(c.mesh, neighbors_of(c.mesh)),
          edit(mesh, fixed, edges, c.field, c.structures, wide()) {
        edit.table = &c.regions;
        edit.goal = 0.3;
    }
    static MeshImprovementOptions wide() {
        MeshImprovementOptions options;
        options.max_deviation_mm = 100;
        return options;
    }
    // Tries it on every cell inside. How often it was done.
    template <class Operation>
    std::size_t try_all(const Operation& operation) {
        std::size_t done = 0;
        const std::size_t count = mesh.cell_count();
        for (std::uint32_t c = 0; c < count; ++c) {
            if (mesh.alive(c) && mesh.region(c) != 0) done += operation(edit, c);
        }
        return done;
    }
    TetMesh take() {
        std::vector<std::uint32_t> neighbors;
        TetMesh taken = std::move(mesh).take(neighbors);
        EXPECT_EQ(neighbors, neighbors_of(taken));
        return taken;
    }

    std::vector<std::uint8_t> fixed;
    EditMesh mesh;
    EditContext edit;
};

double volume_of(const TetMesh& mesh, const RegionTable& regions, std::uint32_t structure) {
    double sum = 0;
    for (std::size_t n = 0; n < mesh.cells.size(); ++n) {
        const Cell& c = mesh.cells[n];
        if (regions.contains(mesh.regions[n], structure))
            sum += signed_volume(mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]);
    }
    return sum;
}

TEST(LastOperations, giving_cells_away_keeps_every_surface_and_the_fixed_vertices_on_it) {
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        EditFixture edit(c);
        EXPECT_GT(edit.try_all(relabel_cell), 10u);
        const TetMesh mesh = edit.take();
        EXPECT_EQ(mesh.cells, c.mesh.cells);
        expect_same_surfaces(mesh, c.mesh, c.regions, c.structures);
        expect_sound_regions(mesh, c.regions);
        for (std::uint32_t s = 0; s < c.structures; ++s) {
            const auto before = on_surface(c.mesh, c.regions, s), after = on_surface(mesh, c.regions, s);
            for (std::size_t v = 0; v < c.fixed.size(); ++v)
                ASSERT_TRUE(!c.fixed[v] || !before[v] || after[v]);
        }
    }
}

// A cell goes to the outside, or to where it has fewer facets between two regions: so giving ends.
TEST(LastOperations, giving_cells_away_ends) {
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        EditFixture edit(c);
        int rounds = 0;
        while (edit.try_all(relabel_cell) > 0) ASSERT_LT(++rounds, 200);
    }
}

// A single flat cell between two structures, in a region of its own, joins one of them.
TEST(LastOperations, a_lone_cell_where_two_structures_overlap_goes_to_one_of_them) {
    LabelledCase c = sampled_case(
        "touching balls", AnalyticField({ball({-4, 0, 0}, 4), ball({4, 0, 0}, 4)}, 9, true), 2, 1'000'000);
    const auto both = static_cast<Region>(c.regions.members.size());
    c.regions.members.push_back({0, 1});
    const std::vector<std::uint32_t> neighbors = neighbors_of(c.mesh);
    std::uint32_t made = no_cell;
    for (std::uint32_t n = 0; n < c.mesh.cells.size() && made == no_cell; ++n) {
        // Two facets on either side.
        int here = 0, there = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint32_t other = neighbors[4 * n + i];
            if (other == no_cell) continue;
            here += c.regions.members[c.mesh.regions[other]] == std::vector<std::uint32_t>{0};
            there += c.regions.members[c.mesh.regions[other]] == std::vector<std::uint32_t>{1};
        }
        if (here == 2 && there == 2) made = n;
    }
    ASSERT_NE(made, no_cell);
    c.mesh.regions[made] = both;
    EditFixture edit(c);
    ASSERT_TRUE(relabel_cell(edit.edit, made));
    EXPECT_NE(edit.mesh.region(made), both);
    EXPECT_NE(edit.mesh.region(made), 0);
    expect_same_surfaces(edit.take(), c.mesh, c.regions, 2);
}

// No facet comes into the plane of a slice between the inside and the outside where nothing is drawn there.
TEST(LastOperations, giving_cells_away_leaves_the_cuts_by_slices) {
    LabelledCase c = sampled_case("ball", AnalyticField({ball({}, 5)}, 6), 1);
    c.field = AnalyticField({ball({}, 4.8)}, 6);  // drawn
    const std::vector<std::uint32_t> in_one_slice(c.mesh.points.size(), 0);
    const DrawnSlices slices{&c.regions, in_one_slice};
    EditFixture free(c), held(c);
    held.edit.drawn = &slices;
    held.edit.rule.guards_sections = true;
    const std::size_t relabelled = held.try_all(relabel_cell);
    EXPECT_GT(relabelled, 0u);
    EXPECT_GT(free.try_all(relabel_cell), relabelled);
    const TetMesh mesh = held.take();
    const std::vector<std::uint32_t> neighbors = neighbors_of(mesh);
    for (std::size_t f = 0; f < neighbors.size(); ++f) {
        if (neighbors[f] == no_cell || c.mesh.regions[f / 4] == mesh.regions[f / 4] ||
            mesh.regions[f / 4] == mesh.regions[neighbors[f]] ||
            c.mesh.regions[f / 4] != mesh.regions[neighbors[f]])
            continue;
        Vec3 middle;
        for (const int k : facet_vertices[f % 4]) middle += (1.0 / 3) * mesh.points[mesh.cells[f / 4][k]];
        EXPECT_LE(length(middle), 4.8 + 1e-9);
    }
}

std::vector<Triangle> sorted_surface(const TetMesh& mesh, const RegionTable& regions, std::uint32_t s) {
    std::vector<Triangle> surface = structure_surface(mesh, regions, s);
    for (Triangle& f : surface) std::sort(f.begin(), f.end());
    std::sort(surface.begin(), surface.end());
    return surface;
}

// All edges of the surfaces between fixed vertices.
std::vector<VertexPair> fixed_edges_of(const LabelledCase& c) {
    std::vector<VertexPair> edges;
    for (std::uint32_t s = 0; s < c.structures; ++s) {
        for (const Triangle& f : structure_surface(c.mesh, c.regions, s)) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = f[i], b = f[(i + 1) % 3];
                if (c.fixed[a] && c.fixed[b]) edges.push_back({std::min(a, b), std::max(a, b)});
            }
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

TEST(LastOperations, new_vertices_keep_surfaces_in_place_and_fixed_edges_as_chains) {
    for (LabelledCase c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        for (std::size_t v = 0; v < c.fixed.size(); v += 2) c.fixed[v] = 1;
        const std::vector<VertexPair> edges = fixed_edges_of(c);
        EditFixture edit(c, edges);
        const std::size_t done = edit.try_all([](EditContext& w, std::uint32_t cell) {
            if (w.sine(cell) > 0.2) return false;
            for (int e = 0; e < 6; ++e) {
                if (split_edge(w, cell, e)) return true;
            }
            for (int i = 0; i < 4; ++i) {
                if (split_facet(w, cell, i)) return true;
            }
            return split_cell(w, cell) || insert_beside(w, cell);
        });
        EXPECT_GT(done, 0u);
        EXPECT_EQ(edit.edit.stats.operations.vertices_inserted, done);
        const std::vector<std::uint8_t> fixed = edit.fixed;
        const TetMesh mesh = edit.take();
        EXPECT_GT(mesh.points.size(), c.mesh.points.size());
        expect_sound_mesh(mesh, c.mesh);
        expect_same_surfaces(mesh, c.mesh, c.regions, c.structures);
        EXPECT_GE(worst_sine(mesh), worst_sine(c.mesh));
        EXPECT_LE(worst_ratio(mesh), std::max(2.0, worst_ratio(c.mesh)) * (1 + 1e-9));
        for (std::uint32_t s = 0; s < c.structures; ++s) {
            const double volume = volume_of(c.mesh, c.regions, s);
            EXPECT_NEAR(volume_of(mesh, c.regions, s), volume, 1e-9 * volume);
        }
        // As many edges more as there are new vertices that are fixed.
        const std::vector<VertexPair> chains = edges_along(mesh, neighbors_of(mesh), edges);
        const auto on_edges =
            std::count(fixed.begin() + static_cast<std::ptrdiff_t>(c.fixed.size()), fixed.end(), 1);
        EXPECT_EQ(chains.size(), edges.size() + static_cast<std::size_t>(on_edges));
        for (const auto& [a, b] : chains) EXPECT_TRUE(fixed[a] && fixed[b]);
    }
}

// Flat cells that lie on an interface one beside the other get a vertex under them all: facets of surfaces
// stay what they are, and no angle but the flat ones changes for the worse.
TEST(LastOperations, a_vertex_beside_flat_cells_leaves_every_facet_of_a_surface) {
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        EditFixture edit(c);
        const std::size_t done = edit.try_all(
            [](EditContext& w, std::uint32_t cell) { return w.sine(cell) <= 0.2 && insert_beside(w, cell); });
        EXPECT_GT(done, 0u);
        EXPECT_EQ(edit.edit.stats.operations.vertices_inserted, done);
        const TetMesh mesh = edit.take();
        expect_sound_mesh(mesh, c.mesh);
        EXPECT_GE(worst_sine(mesh), worst_sine(c.mesh));
        EXPECT_LE(worst_ratio(mesh), std::max(2.0, worst_ratio(c.mesh)) * (1 + 1e-9));
        for (std::uint32_t s = 0; s < c.structures; ++s)
            EXPECT_EQ(sorted_surface(mesh, c.regions, s), sorted_surface(c.mesh, c.regions, s));
    }
}

std::size_t regions_at(EditMesh& mesh, std::uint32_t v) {
    std::vector<std::uint32_t> star;
    mesh.star(v, star);
    std::vector<Region> regions;
    for (const std::uint32_t c : star) regions.push_back(mesh.region(c));
    std::sort(regions.begin(), regions.end());
    return static_cast<std::size_t>(std::unique(regions.begin(), regions.end()) - regions.begin());
}

// Vertices where three regions meet move, when they may, by no more than surfaces may leave the field's.
TEST(LastOperations, junctions_move_within_the_bound_and_only_uphill) {
    std::size_t moved = 0;
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        for (const bool allowed : {false, true}) {
            EditFixture edit(c);
            edit.edit.options.max_deviation_mm = 0.2;
            edit.edit.rule.moves_junctions = allowed;
            const double before = worst_sine(c.mesh);
            const std::size_t tried = edit.try_all([&](EditContext& on, std::uint32_t cell) {
                if (on.sine(cell) >= 0.25) return false;
                std::size_t done = 0;
                for (const std::uint32_t v : Cell(on.mesh.cell(cell)))
                    done += regions_at(on.mesh, v) > 2 && move_vertex(on, v);
                return done > 0;
            });
            if (!allowed) {
                EXPECT_EQ(tried, 0u);
                continue;
            }
            moved += tried;
            const TetMesh mesh = edit.take();
            expect_sound_mesh(mesh, c.mesh);
            expect_same_surfaces(mesh, c.mesh, c.regions, c.structures);
            EXPECT_GE(worst_sine(mesh), before);
            for (std::size_t v = 0; v < c.fixed.size(); ++v) {
                EXPECT_TRUE(!c.fixed[v] || mesh.points[v] == c.mesh.points[v]);
                // Each vertex is in a few bad cells, and is tried with each.
                EXPECT_LT(length(mesh.points[v] - c.mesh.points[v]), 20 * 0.2);
            }
        }
    }
    EXPECT_GT(moved, 10u);
}

// Judged by ratios, operations leave fewer of the high ones, and no angle below the bound that was above it.
TEST(LastOperations, those_for_ratios_lower_them_and_spare_good_angles) {
    constexpr double most = 2.5, least_sine = 0.17;
    std::size_t before = 0, after = 0;
    for (const LabelledCase& c : labelled_cases()) {
        SCOPED_TRACE(c.name);
        EditFixture edit(c);
        edit.edit.rule.max_radius_edge = most;
        edit.edit.rule.objective = Objective::radius_edge;
        edit.edit.rule.least_sine = least_sine;
        const auto is_high = [&](std::uint32_t cell) {
            return edit.mesh.alive(cell) && edit.mesh.region(cell) != 0 &&
                   edit.edit.threshold_of({&cell, 1}).squared_ratio > most * most;
        };
        std::vector<std::uint32_t> high;
        for (std::uint32_t cell = 0; cell < edit.mesh.cell_count(); ++cell) {
            if (is_high(cell)) high.push_back(cell);
        }
        before += high.size();
        for (const std::uint32_t cell : high) {
            for (int e = 0; e < 6 && is_high(cell); ++e) remove_edge(edit.edit, cell, e);
            for (int i = 0; i < 4 && is_high(cell); ++i) remove_facet(edit.edit, cell, i);
            for (int i = 0; i < 4 && is_high(cell); ++i) move_vertex(edit.edit, edit.mesh.cell(cell)[i]);
            for (int e = 0; e < 12 && is_high(cell); ++e) collapse_edge(edit.edit, cell, e / 2, e % 2 == 0);
            for (int e = 0; e < 6 && is_high(cell); ++e) insert_vertex(edit.edit, cell, e);
        }
        for (std::uint32_t cell = 0; cell < edit.mesh.cell_count(); ++cell) after += is_high(cell);
        const TetMesh mesh = edit.take();
        expect_sound_mesh(mesh, c.mesh);
        expect_same_surfaces(mesh, c.mesh, c.regions, c.structures);
        EXPECT_GE(worst_sine(mesh), std::min(worst_sine(c.mesh), least_sine));
    }
    EXPECT_GT(before, 500u);
    EXPECT_LT(8 * after, before) << before << " before, " << after << " after";
}

}  // namespace
}  // namespace anatomesh::last_operations_test
