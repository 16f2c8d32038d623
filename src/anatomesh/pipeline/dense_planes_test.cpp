// Freehand planes that lie closer to each other than the vertices along their contours.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/pipeline/dense_planes_for_test.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::dense_planes_test {
namespace {

using namespace fixtures;
using namespace dense_plane_sets;

// As sets of many vertices are built.
Result<Model> build_spared(const ContourSet& set, RunContext& context) {
    ModelOptions options;
    options.spare_dense_above = 0;
    return build_model(set, options, context);
}

double share_of_segments_kept(const Model& model) {
    const StructureReport& ball = model.report.structures[0];
    return static_cast<double>(ball.fidelity.segments_on_surface) /
           static_cast<double>(ball.fidelity.segments);
}

// Those of which the contract allows none.
std::size_t cells_that_nothing_forces(const Model& model) {
    const std::vector<ListedCell>& cells = model.report.listed_cells.cells;
    return static_cast<std::size_t>(std::count_if(cells.begin(), cells.end(), [](const ListedCell& cell) {
        return cell.forced_by.empty() && (cell.value > 4 || cell.min_dihedral_deg < 10);
    }));
}

// At a pole contours meet at a few degrees: what they force there is the price of their segments.
TEST(DensePlanes, keep_their_contour_segments_in_cells_as_good_as_these_let_them) {
    struct Set {
        std::string name;
        ContourSet contours;
        double least_kept, most_over_bound;
    };
    std::vector<Set> sets;
    for (const int planes : {50, 60, 70})
        sets.push_back({"sweep of " + std::to_string(planes), sweep(planes, 50), 0.97, 0.008});
    for (const int planes : {20, 40})
        sets.push_back({std::to_string(planes) + " planes about an axis", turned(planes, 30), 0.999, 0.05});
    // Nearly all vertices of its surface lie on contours, and too few are left to make the volume right: it
    // is built without all that its segments ask for.
    sets.push_back({"30 planes about an axis", turned(30, 30), 0.95, 0.05});
    for (const auto& [name, set, least_kept, most_over_bound] : sets) {
        SCOPED_TRACE(name);
        RunContext context;
        const auto made = build_model(set, {}, context);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        const Model& model = made.value();
        EXPECT_GT(share_of_segments_kept(model), least_kept);
        EXPECT_LE(cells_that_nothing_forces(model), 3u);
        EXPECT_LT(model.report.quality.radius_edge.share_over_2, most_over_bound);
        EXPECT_TRUE(std::none_of(context.warnings.begin(), context.warnings.end(),
                                 [](const Warning& w) { return w.code == "W-PIP-005"; }));
        expect_structure(model, 0, {1, 0, 4.0 / 3 * pi * radius * radius * radius, 0.03});
    }
}

TEST(DensePlanes, four_times_the_planes_make_hardly_more_cells) {
    std::vector<double> cells;  // a contour vertex
    for (const int planes : {30, 120}) {
        const ContourSet set = sweep(planes, 80);
        RunContext context;
        auto made = build_spared(set, context);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        const Model& model = made.value();
        cells.push_back(static_cast<double>(model.mesh.cells.size()) /
                        static_cast<double>(set.points.size()));
        ASSERT_EQ(model.contour_vertices.size(), set.points.size());
        for (std::size_t n = 0; n < set.points.size(); ++n)
            EXPECT_EQ(model.mesh.points[model.contour_vertices[n]], set.points[n]);
        for (const int number : {1, 3, 6})
            EXPECT_EQ(model.report.certificate[static_cast<std::size_t>(number - 1)].state, ClauseState::kept)
                << number;
        expect_structure(model, 0, {1, 0, 4.0 / 3 * pi * radius * radius * radius, 0.03});
    }
    EXPECT_LT(cells[1], 0.4 * cells[0]);
    EXPECT_LT(cells[1], 20);
}

TEST(DensePlanes, say_that_cells_were_left_as_they_come_and_a_given_size_does_more) {
    const auto count_of = [](const RunContext& context, const std::string& code) {
        return std::count_if(context.warnings.begin(), context.warnings.end(),
                             [&](const Warning& w) { return w.code == code; });
    };
    const ContourSet dense = sweep(60, 40);
    RunContext quick, full;
    const auto first = build_spared(dense, quick);
    ASSERT_TRUE(first.ok()) << to_line(first.error());
    EXPECT_EQ(count_of(quick, "W-PIP-005"), 1);
    ModelOptions options;
    options.size_mm = first.value().report.lengths.size_mm;
    const auto second = build_model(dense, options, full);
    ASSERT_TRUE(second.ok()) << to_line(second.error());
    EXPECT_EQ(count_of(full, "W-PIP-005"), 0);
    EXPECT_LT(second.value().report.quality.radius_edge.share_over_2,
              first.value().report.quality.radius_edge.share_over_2);
    EXPECT_LT(second.value().report.quality.dihedral_deg.below_10,
              first.value().report.quality.dihedral_deg.below_10);
    EXPECT_GT(share_of_segments_kept(second.value()), share_of_segments_kept(first.value()) + 0.2);
}

// An edge of the surface at which its facets meet at a wide angle belongs to a pit or a spike where the solid
// is round.
struct Roughness {
    double worst_mm = 0;  // of a vertex from the truth
    double mean_angle = 0, sharp_share = 0;
};

Roughness roughness_of(const Model& model, double solid_radius, double beyond) {
    Roughness rough;
    const auto neighbors = cell_neighbors(model.mesh.cells, model.mesh.points.size());
    const std::vector<Triangle> surface = structure_surface(model.mesh, neighbors, model.regions, 0);
    std::map<std::array<std::uint32_t, 2>, Vec3> open;
    std::size_t edges = 0, sharp = 0;
    for (const Triangle& facet : surface) {
        const auto& p = model.mesh.points;
        const Vec3 normal = normalized(cross(p[facet[1]] - p[facet[0]], p[facet[2]] - p[facet[0]]));
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = facet[i], b = facet[(i + 1) % 3];
            // The ends of the sweep are flat.
            if (std::abs(p[a].z) > beyond || std::abs(p[b].z) > beyond) continue;
            rough.worst_mm = std::max(rough.worst_mm, std::abs(length(p[a]) - solid_radius));
            const auto [other, is_new] = open.insert({{std::min(a, b), std::max(a, b)}, normal});
            if (is_new) continue;
            const double angle = std::acos(std::clamp(dot(normal, other->second), -1.0, 1.0)) * 180 / pi;
            ++edges;
            rough.mean_angle += angle;
            sharp += angle > 45;
        }
    }
    rough.mean_angle /= static_cast<double>(edges);
    rough.sharp_share = static_cast<double>(sharp) / static_cast<double>(edges);
    return rough;
}

TEST(DensePlanes, leave_no_pits) {
    for (const int planes : {60, 120, 240}) {
        SCOPED_TRACE(planes);
        const ContourSet set = sweep(planes, 60);
        RunContext context;
        const auto made = build_spared(set, context);
        ASSERT_TRUE(made.ok()) << to_line(made.error());
        const Roughness rough = roughness_of(made.value(), radius, 0.8 * radius);
        EXPECT_LT(rough.worst_mm, 0.45);
        EXPECT_LT(rough.mean_angle, 6);
        EXPECT_LT(rough.sharp_share, 0.015);
        expect_structure(made.value(), 0, {1, 0, 4.0 / 3 * pi * radius * radius * radius, 0.03});
    }
}

}  // namespace
}  // namespace anatomesh::dense_planes_test
