#include "anatomesh/measure/contour_movement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "anatomesh/measure/certificate/certificate.h"

namespace anatomesh::contour_movement_test {
namespace {

// A stack of squares with a vertex every 2 mm, `spacing_mm` apart; those of `structures` side by side.
ContourSet squares(double spacing_mm, std::uint32_t structures = 1) {
    ContourSet set;
    for (std::uint32_t s = 0; s < structures; ++s)
        set.structures.push_back({static_cast<int>(s) + 1, "", {}});
    for (std::uint32_t k = 0; k < 9; ++k) {
        const double z = spacing_mm * k;
        set.slices.push_back({{{0, 0, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                              static_cast<std::uint32_t>(set.contours.size()),
                              structures,
                              std::to_string(k)});
        for (std::uint32_t s = 0; s < structures; ++s) {
            set.contours.push_back({s, k, static_cast<std::uint32_t>(set.points.size()), 40});
            const double x = 30.0 * s;
            for (int n = 0; n < 10; ++n) set.points.push_back({x + 2 * n, 0, z});
            for (int n = 0; n < 10; ++n) set.points.push_back({x + 20, 2.0 * n, z});
            for (int n = 0; n < 10; ++n) set.points.push_back({x + 20 - 2 * n, 20, z});
            for (int n = 0; n < 10; ++n) set.points.push_back({x, 20.0 - 2 * n, z});
        }
    }
    return set;
}

void shift(ContourSet& set, std::uint32_t contour, Vec3 way) {
    const Contour& moved = set.contours[contour];
    for (std::uint32_t k = moved.first_point; k < moved.first_point + moved.point_count; ++k)
        set.points[k] += way;
}

ModelReport report_of(const ContourMovementReport& movement) {
    ModelReport report;
    for (int n = 1; n <= 6; ++n) report.certificate.push_back({n, ClauseState::kept, "", "as measured"});
    report.crossing.movement = movement;
    return report;
}

// Moved is what is farther off than half a spacing, and the clauses of contours say so; less is kept.
TEST(ContourMovement, clauses_of_contours_are_moved_above_half_a_spacing) {
    std::size_t members = 0;
    for (const double spacing : {1.0, 2.5, 4.0, 8.0}) {
        for (const double share : {0.05, 0.2, 0.4, 0.49, 0.51, 0.6, 0.9, 1.2}) {
            for (const std::uint32_t count : {1u, 4u}) {
                const ContourSet drawn = squares(spacing, 2);
                ContourSet kept = drawn;
                for (std::uint32_t c = 0; c < count; ++c) shift(kept, 3 * c, {share * spacing, 0, 0});
                const ContourMovementReport movement = contour_movement(drawn, kept);
                EXPECT_NEAR(movement.bound_mm, 0.5 * spacing, 1e-9);
                EXPECT_NEAR(movement.farthest_mm, share * spacing, 1e-9);
                EXPECT_EQ(movement.contours, 18u);
                EXPECT_EQ(movement.contours_moved, share > 0.5 ? count : 0u);
                EXPECT_EQ(movement.vertices_moved > 0, share > 0.5);
                ModelReport report = report_of(movement);
                state_movement(report);
                for (const Clause& clause : report.certificate) {
                    const bool of_contours = clause.number <= 2;
                    EXPECT_EQ(clause.state,
                              of_contours && share > 0.5 ? ClauseState::moved : ClauseState::kept);
                    if (!of_contours) EXPECT_EQ(clause.evidence, "as measured");
                }
                const std::string& evidence = report.certificate[0].evidence;
                EXPECT_NE(evidence.find(" mm"), std::string::npos) << evidence;
                EXPECT_EQ(evidence.find("half a slice spacing") != std::string::npos, share > 0.5)
                    << evidence;
                ++members;
            }
        }
    }
    EXPECT_GE(members, 50u);
}

// What was cut off counts, though every vertex that is left stays where it was.
TEST(ContourMovement, counts_what_was_cut_off_came_or_went) {
    const ContourSet drawn = squares(4);
    ContourSet cut = drawn;
    std::fill(cut.points.begin() + 12, cut.points.begin() + 19, cut.points[30]);
    EXPECT_EQ(contour_movement(drawn, drawn).contours_moved, 0u);
    EXPECT_EQ(contour_movement(drawn, drawn).farthest_mm, 0);
    EXPECT_EQ(contour_movement(drawn, cut).contours_moved, 1u);
    EXPECT_GT(contour_movement(drawn, cut).farthest_mm, 5);
    ContourSet without = drawn;
    without.slices[8].contour_count = 0;
    without.contours.pop_back();
    EXPECT_EQ(contour_movement(drawn, without).contours_moved, 1u);
    EXPECT_EQ(contour_movement(without, drawn).contours_moved, 1u);
}

// A vertex that slid along its contour, or was put into it, moved nothing.
TEST(ContourMovement, does_not_count_vertices_that_slid_along_their_contour) {
    const ContourSet drawn = squares(1);
    ContourSet slid = drawn;
    for (const std::uint32_t k : {3u, 5u, 44u}) slid.points[k].x += 0.9;
    EXPECT_LE(contour_movement(drawn, slid).farthest_mm, 1e-9);
    EXPECT_EQ(contour_movement(drawn, slid).contours_moved, 0u);
}

// A clause that is not met stays so, and contours at edges of the surface count too.
TEST(ContourMovement, leaves_unmet_clauses_and_counts_rerouted_contours) {
    ModelReport report = report_of({});
    report.certificate[1].state = ClauseState::not_promised_yet;
    report.lengths.slice_spacing_mm = 2;
    report.contours.routed = {{"", "1", 3, 0, 0.9, 1}};
    state_movement(report);
    EXPECT_EQ(report.certificate[0].state, ClauseState::kept);
    EXPECT_EQ(report.certificate[0].evidence, "as measured");
    report.contours.routed.push_back({"", "2", 3, 0, 1.1, 1});
    state_movement(report);
    EXPECT_EQ(report.certificate[0].state, ClauseState::moved);
    EXPECT_EQ(report.certificate[1].state, ClauseState::not_promised_yet);
}

}  // namespace
}  // namespace anatomesh::contour_movement_test
