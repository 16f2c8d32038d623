#include "anatomesh/improve/climb/climb_profile.h"

#include <gtest/gtest.h>

#include <set>

#include "anatomesh/improve/core/quality_gate.h"

namespace anatomesh::climb_profile_test {
namespace {

TEST(CellOperations, every_operation_is_attempted_once_in_each_place_and_the_cheap_ones_come_first) {
    std::set<std::pair<CellOperation, int>> seen;
    for (std::size_t n = 0; n < operation_attempts.size(); ++n) {
        const OperationAttempt& attempt = operation_attempts[n];
        EXPECT_TRUE(seen.insert({attempt.kind, attempt.place}).second);
        EXPECT_TRUE(thorough_operations.has(attempt.kind));
        const bool is_speculative = attempt.kind <= CellOperation::move_vertex;
        EXPECT_EQ(n < speculative_attempts, is_speculative);
        EXPECT_TRUE(n == 0 || operation_attempts[n - 1].kind <= attempt.kind);
    }
    EXPECT_EQ(seen.size(), 45u);
}

TEST(CellOperations, sets_gain_and_lose_kinds) {
    const OperationSet set = OperationSet().with(CellOperation::relabel).with(CellOperation::split_cell);
    EXPECT_TRUE(set.has(CellOperation::relabel));
    EXPECT_FALSE(set.has(CellOperation::remove_edge));
    EXPECT_EQ(set.without(CellOperation::relabel), OperationSet().with(CellOperation::split_cell));
    EXPECT_EQ(set.with(CellOperation::relabel), set);
}

TEST(ClimbProfiles, every_row_has_cells_to_work_on) {
    for (const ClimbProfile& row : ClimbProfiles(MeshImprovementOptions{}).rows())
        EXPECT_TRUE(row.target_sine > 0 || row.target_ratio < HUGE_VAL);
}

TEST(ClimbProfiles, bounds_follow_the_options) {
    MeshImprovementOptions options;
    options.target_degrees = 20;
    options.max_radius_edge = 2.5;
    options.last_radius_edge = 3.5;
    const ClimbProfiles profiles(options);
    EXPECT_EQ(profiles[ClimbPass::angles].target_sine, target_sine(options));
    EXPECT_EQ(profiles[ClimbPass::angles].rule.max_radius_edge, 2.5);
    EXPECT_EQ(profiles[ClimbPass::high_ratios].target_ratio, 3.5);
    EXPECT_EQ(profiles[ClimbPass::ratios].target_ratio, 2.5);
    double before = 2.5;
    for (const ClimbPass pass :
         {ClimbPass::listed_angles_1, ClimbPass::listed_angles_2, ClimbPass::listed_angles_3}) {
        EXPECT_GT(profiles[pass].rule.max_radius_edge, before);
        EXPECT_EQ(profiles[pass].rule.least_sine, listed_sine());
        before = profiles[pass].rule.max_radius_edge;
    }
    EXPECT_NEAR(before, 3.5, 1e-12);
}

// Clause 4 bounds what a pass may leave: no row lets a new cell be worse than the last bound, but for flat
// cells, which the bounds of forced cells hold.
TEST(ClimbProfiles, no_row_allows_more_than_the_last_bounds) {
    const MeshImprovementOptions options;
    const ClimbProfiles profiles(options);
    for (const ClimbProfile& row : profiles.rows()) {
        SCOPED_TRACE(&row - &profiles.rows().front());
        const bool is_for_flat_cells = &row == &profiles[ClimbPass::flat_cells];
        EXPECT_LE(row.rule.max_radius_edge,
                  is_for_flat_cells ? most_limited_ratio : options.last_radius_edge);
        EXPECT_EQ(row.condition == Condition::all_good, is_for_flat_cells);
    }
}

TEST(ClimbProfiles,
     cells_are_relabelled_for_a_ratio_only_where_the_caller_says_so_or_it_is_above_the_last_bound) {
    MeshImprovementOptions options;
    options.relabels_for_ratio = false;
    EXPECT_EQ(ClimbProfiles(options)[ClimbPass::ratios].relabels_above, options.last_radius_edge);
    EXPECT_EQ(ClimbProfiles(options)[ClimbPass::flat_cells].relabels_above, HUGE_VAL);
    options.relabels_for_ratio = true;
    EXPECT_EQ(ClimbProfiles(options)[ClimbPass::ratios].relabels_above, 0);
    EXPECT_EQ(ClimbProfiles(options)[ClimbPass::flat_cells].relabels_above, 0);
}

}  // namespace
}  // namespace anatomesh::climb_profile_test
