#include "anatomesh/improve/climb/hill_climber.h"

#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/labelled_meshes_for_test.h"

namespace anatomesh::hill_climber_test {
namespace {

using namespace fixtures;

// A case on an edit context with a hill climber.
struct Climb {
    explicit Climb(const LabelledCase& c, int threads = 1, std::vector<std::uint8_t> limited = {})
        : constraint_limited(std::move(limited)),
          fixed(c.fixed),
          neighbors(cell_neighbors(c.mesh.cells, c.mesh.points.size())),
          mesh(c.mesh, neighbors),
          edit(mesh, fixed, {}, c.field, c.structures, {}),
          climber(edit, context),
          profiles(edit.options) {
        context.threads = threads;
        edit.table = &c.regions;
        drawn.table = &c.regions;
        drawn.constraint_limited = constraint_limited;
        edit.drawn = &drawn;
        edit.goal = 0.3;
    }
    BadCellQueue bad(ClimbPass pass) {
        return climber.queue_of(profiles[pass], edit.mesh.alive_cells(), context.threads);
    }
    TetMesh take() {
        TetMesh taken = std::move(mesh).take(neighbors);
        return taken;
    }

    RunContext context;
    std::vector<std::uint8_t> constraint_limited;
    DrawnSlices drawn;
    std::vector<std::uint8_t> fixed;
    std::vector<std::uint32_t> neighbors;
    EditMesh mesh;
    EditContext edit;
    HillClimber climber;
    ClimbProfiles profiles;
};

LabelledCase torus_case() {
    return random_case("random torus", AnalyticField({torus(6, 2.5)}, 9), 1, 1);
}

TEST(BadCellQueue, gives_the_worst_cell_first_and_of_two_the_one_with_the_smaller_number) {
    BadCellQueue queue({{0.3, 1}, {0.1, 7}, {0.1, 2}});
    queue.push({0.2, 4});
    EXPECT_EQ(queue.size(), 4u);
    EXPECT_EQ(queue.worst().cell, 2u);
    EXPECT_EQ(queue.take_cells(), (std::vector<std::uint32_t>{2, 7, 4, 1}));
    EXPECT_TRUE(queue.empty());
}

TEST(HillClimber, leaves_fewer_bad_cells_and_queues_just_those) {
    const LabelledCase c = torus_case();
    Climb climb(c);
    BadCellQueue queue = climb.bad(ClimbPass::angles);
    const std::size_t before = queue.size();
    const double worst = queue.worst().sine;
    std::vector<std::uint32_t> changed;
    climb.climber.climb(climb.profiles[ClimbPass::angles], queue, changed);
    EXPECT_GT(before, 10u);
    EXPECT_LT(queue.size(), before / 2);
    EXPECT_TRUE(queue.empty() || queue.worst().sine >= worst);
    EXPECT_EQ(queue.take_cells(), climb.bad(ClimbPass::angles).take_cells());
    EXPECT_TRUE(changed.empty());
    expect_sound_mesh(climb.take(), c.mesh);
}

TEST(HillClimber, makes_the_same_mesh_on_several_threads) {
    const LabelledCase c = torus_case();
    Climb one(c), three(c, 3);
    std::vector<std::uint32_t> changed, changed_by_three;
    BadCellQueue queue = one.bad(ClimbPass::last_angles), of_three = three.bad(ClimbPass::last_angles);
    one.climber.climb(one.profiles[ClimbPass::last_angles], queue, changed);
    three.climber.climb(three.profiles[ClimbPass::last_angles], of_three, changed_by_three);
    EXPECT_FALSE(changed.empty());
    EXPECT_EQ(changed, changed_by_three);
    const TetMesh mesh = one.take(), mesh_of_three = three.take();
    EXPECT_EQ(mesh.points, mesh_of_three.points);
    EXPECT_EQ(mesh.cells, mesh_of_three.cells);
    EXPECT_EQ(mesh.regions, mesh_of_three.regions);
}

TEST(HillClimber, lowers_ratios_at_no_angle_below_the_least_of_its_profile) {
    const LabelledCase c = torus_case();
    Climb climb(c);
    const ClimbProfile& profile = climb.profiles[ClimbPass::ratios];
    const std::vector<std::uint32_t> cells = climb.climber.bad_cells(profile, 1);
    ASSERT_GT(cells.size(), 10u);
    std::vector<std::uint32_t> changed;
    EXPECT_GT(climb.climber.climb_list(profile, cells, changed), 0u);
    EXPECT_LT(climb.climber.bad_cells(profile, 1).size(), cells.size());
    for (const std::uint32_t n : changed) {
        if (!climb.edit.mesh.alive(n) || climb.edit.mesh.region(n) == 0) continue;
        EXPECT_GE(climb.edit.sine(n), profile.rule.strict_least_sine);
    }
    expect_sound_mesh(climb.take(), c.mesh);
}

TEST(HillClimber, visits_no_more_cells_than_allowed) {
    const LabelledCase c = torus_case();
    Climb climb(c);
    const ClimbProfile& profile = climb.profiles[ClimbPass::ratios];
    std::vector<std::uint32_t> changed;
    EXPECT_EQ(climb.climber.climb_list(profile, climb.climber.bad_cells(profile, 1), changed, 0), 0u);
    EXPECT_TRUE(changed.empty());
    EXPECT_LE(climb.climber.climb_list(profile, climb.climber.bad_cells(profile, 1), changed, 3), 3u);
    EXPECT_FALSE(changed.empty());
}

TEST(HillClimber, puts_the_rule_back) {
    const LabelledCase c = torus_case();
    Climb climb(c);
    climb.edit.rule.moves_junctions = true;
    climb.edit.rule.max_radius_edge = 2.25;
    std::vector<std::uint32_t> changed;
    const ClimbProfile& profile = climb.profiles[ClimbPass::blemishes];
    EXPECT_GT(climb.climber.climb_list(profile, climb.climber.bad_cells(profile, 1), changed), 0u);
    EXPECT_TRUE(climb.edit.rule.moves_junctions);
    EXPECT_FALSE(climb.edit.rule.spares_limited);
    EXPECT_FALSE(climb.edit.rule.guards_sections);
    EXPECT_EQ(climb.edit.rule.max_radius_edge, 2.25);
    EXPECT_EQ(climb.edit.rule.objective, Objective::least_sine);
}

TEST(HillClimber, leaves_exempt_cells_alone) {
    const LabelledCase c = torus_case();
    Climb all_limited(c, 1, std::vector<std::uint8_t>(c.mesh.points.size(), 1));
    EXPECT_TRUE(all_limited.climber.bad_cells(all_limited.profiles[ClimbPass::blemishes], 1).empty());
    EXPECT_TRUE(all_limited.climber.bad_cells(all_limited.profiles[ClimbPass::surgery_ratios], 1).empty());
    EXPECT_FALSE(all_limited.climber.bad_cells(all_limited.profiles[ClimbPass::ratios], 1).empty());
    Climb free(c);
    EXPECT_FALSE(free.climber.bad_cells(free.profiles[ClimbPass::blemishes], 1).empty());
    EXPECT_LT(all_limited.bad(ClimbPass::surgery_angles).size(), free.bad(ClimbPass::surgery_angles).size());
}

TEST(HillClimber, a_change_that_breaks_the_bounds_of_limited_cells_is_undone) {
    const LabelledCase c = torus_case();
    std::vector<std::uint8_t> limited(c.mesh.points.size(), 0);
    for (std::size_t v = 0; v < limited.size(); v += 2) limited[v] = 1;
    Climb climb(c, 1, limited);
    const ClimbProfile& profile = climb.profiles[ClimbPass::blemishes];
    std::vector<std::uint32_t> changed;
    EXPECT_GT(climb.climber.climb_list(profile, climb.climber.bad_cells(profile, 1), changed), 0u);
    std::size_t of_limited = 0;
    for (const std::uint32_t n : changed) {
        if (!climb.edit.mesh.alive(n) || climb.edit.mesh.region(n) == 0) continue;
        if (!climb.drawn.are_constraint_limited(climb.edit.mesh.cell(n))) continue;
        ++of_limited;
        EXPECT_GE(climb.edit.sine(n), least_limited_sine);
    }
    EXPECT_GT(of_limited, 0u);
    expect_sound_mesh(climb.take(), c.mesh);
}

}  // namespace
}  // namespace anatomesh::hill_climber_test
