#include "anatomesh/improve/surgery/membrane_surgery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>

#include "anatomesh/improve/labelled_meshes_for_test.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/mesh/model/brick_mesh_for_test.h"
#include "anatomesh/sample/analytic_field_for_test.h"

namespace anatomesh::membrane_surgery_test {
namespace {

constexpr double any_sine = 1e-4, no_sine = 2;
constexpr double middle_height = 3;

using LabelledCell = std::pair<Cell, Region>;

// Cubes, the lower half of them of a structure, and a chain of three subsegments that stands on its surface.
struct HalfSpace {
    TetMesh mesh = testing::brick_mesh({8, 8, 6}, [](int, int, int) { return Region{1}; });
    RegionTable table{{{}, {0}}};
    std::vector<std::uint32_t> neighbors;
    std::vector<std::uint8_t> fixed;
    Chain chain{{}, 0};
    ContourOwners owners;
    DrawnSlices drawn;
    fixtures::AnalyticField field{{[](Vec3 p) { return p.z - middle_height; }}, 10};
    MeshImprovementOptions options;

    HalfSpace() {
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            Vec3 centre;
            for (const std::uint32_t v : mesh.cells[c]) centre += 0.25 * mesh.points[v];
            mesh.regions[c] = centre.z < middle_height ? 1 : 0;
        }
        neighbors = cell_neighbors(mesh.cells, mesh.points.size());
        fixed.assign(mesh.points.size(), 0);
        std::vector<std::array<std::uint32_t, 2>> vertices;
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        for (const Vec3 p : {Vec3{3, 3, 3}, Vec3{3, 3, 4}, Vec3{4, 3, 4}, Vec3{4, 3, 3}}) {
            const auto at = std::find(mesh.points.begin(), mesh.points.end(), p);
            chain.vertices.push_back(static_cast<std::uint32_t>(at - mesh.points.begin()));
            vertices.push_back({chain.vertices.back(), 0});
            fixed[chain.vertices.back()] = 1;
        }
        for (std::size_t n = 1; n < chain.vertices.size(); ++n)
            subsegments.push_back({chain.vertices[n - 1], chain.vertices[n], 0});
        owners = ContourOwners(vertices, mesh.points.size(), subsegments);
        drawn.table = &table;
        drawn.owners = &owners;
        options.spike_mm = 10;
        options.max_radius_edge = options.last_radius_edge = 1000;
    }
};

std::vector<LabelledCell> cells_of(const EditMesh& mesh) {
    std::vector<LabelledCell> cells;
    for (const std::uint32_t c : mesh.alive_cells()) {
        cells.push_back({mesh.cell(c), mesh.region(c)});
        std::sort(cells.back().first.begin(), cells.back().first.end());
    }
    std::sort(cells.begin(), cells.end());
    return cells;
}

class MembraneSurgeryTest : public ::testing::Test {
  protected:
    void SetUp() override {
        edit.table = &half.table;
        for (std::size_t n = 1; n < half.chain.vertices.size(); ++n)
            edit.constraints.keep_edge(half.chain.vertices[n - 1], half.chain.vertices[n]);
        const std::vector<Membrane> membranes = find_membranes(edit, half.chain, false);
        ASSERT_FALSE(membranes.empty());
        proposal.relabelling.chain = half.chain;
        proposal.relabelling.membrane = membranes.front();
        proposal.relabelling.own = 0;
        proposal.most_mm = half.options.spike_mm;
        proposal.most_more_where_parted = 1000;
        before = cells_of(edited);
    }

    MembraneSurgery surgery(double least_sine) { return {edit, half.drawn, nullptr, least_sine, improve}; }
    bool chain_is_on_surface() { return SurfaceIncidence(edit).on_surface(half.chain.vertices, 0); }
    bool chain_is_kept() const {
        return edit.constraints.keeps_edge(half.chain.vertices[0], half.chain.vertices[1]);
    }

    HalfSpace half;
    EditMesh edited{TetMesh(half.mesh), half.neighbors};
    EditContext edit{edited, half.fixed, {}, half.field, 1, half.options};
    SurgeryProposal proposal;
    std::vector<LabelledCell> before;
    std::size_t improved = 0;
    ImproveCells improve = [this](std::vector<std::uint32_t>) {
        ++improved;
        ++edit.stats.operations.edges_removed;
        return std::vector<std::uint32_t>{};
    };
};

TEST_F(MembraneSurgeryTest, a_change_that_is_good_stays_with_its_chain_on_the_surface) {
    EXPECT_FALSE(chain_is_on_surface());
    const SurgeryResult result = surgery(any_sine).attempt(proposal);
    EXPECT_EQ(result.verdict, SurgeryVerdict::done);
    EXPECT_FALSE(result.changed.empty());
    EXPECT_TRUE(result.more_above.has_value());
    EXPECT_EQ(improved, 1u);
    EXPECT_EQ(edit.stats.operations.edges_removed, 1u);
    EXPECT_TRUE(chain_is_on_surface());
    EXPECT_FALSE(chain_is_kept());
    const TetMesh mesh = std::move(edited).take(half.neighbors);
    fixtures::expect_sound_mesh(mesh, half.mesh);
    fixtures::expect_same_surfaces(mesh, half.mesh, half.table, 1);
}

TEST_F(MembraneSurgeryTest, a_change_with_bad_cells_is_undone_after_they_were_improved) {
    const SurgeryResult result = surgery(no_sine).attempt(proposal);
    EXPECT_EQ(result.verdict, SurgeryVerdict::in_vain);
    EXPECT_FALSE(result.changed.empty());
    EXPECT_FALSE(result.more_above.has_value());
    EXPECT_EQ(improved, 1u);
    EXPECT_EQ(edit.stats.operations.edges_removed, 0u);
    EXPECT_EQ(cells_of(edited), before);
    EXPECT_FALSE(chain_is_on_surface());
    EXPECT_TRUE(chain_is_kept());
}

TEST_F(MembraneSurgeryTest, a_change_of_another_topology_is_undone_before_cells_are_improved) {
    proposal.topology = TopologyChange::handle_goes;
    const SurgeryResult result = surgery(any_sine).attempt(proposal);
    EXPECT_EQ(result.verdict, SurgeryVerdict::unsound);
    EXPECT_TRUE(result.changed.empty());
    EXPECT_EQ(improved, 0u);
    EXPECT_EQ(cells_of(edited), before);
    EXPECT_TRUE(chain_is_kept());
}

TEST_F(MembraneSurgeryTest, reaches_and_thicknesses_are_attempted_in_turn) {
    constexpr std::array reaches{MembraneReach::wide, MembraneReach::joined};
    std::size_t attempts = 0;
    const auto count = [&](const SurgeryResult&) { return ++attempts != 2; };
    const auto count_all = [&](const SurgeryResult&) { return ++attempts > 0; };
    EXPECT_FALSE(surgery(no_sine).attempt_each(proposal, reaches, membrane_thicknesses, count));
    EXPECT_EQ(attempts, 2u);
    attempts = 0;
    EXPECT_FALSE(surgery(no_sine).attempt_each(proposal, reaches, membrane_thicknesses, count_all));
    EXPECT_EQ(attempts, reaches.size() * membrane_thicknesses.size());
    // Where one is unsound, no other thickness is attempted.
    attempts = 0;
    proposal.topology = TopologyChange::handle_goes;
    EXPECT_FALSE(surgery(any_sine).attempt_each(proposal, reaches, membrane_thicknesses, count_all));
    EXPECT_EQ(attempts, reaches.size());
    attempts = 0;
    proposal.topology = TopologyChange::unchanged;
    EXPECT_TRUE(surgery(any_sine).attempt_each(proposal, reaches, membrane_thicknesses, count_all));
    EXPECT_EQ(attempts, 1u);
}

}  // namespace
}  // namespace anatomesh::membrane_surgery_test
