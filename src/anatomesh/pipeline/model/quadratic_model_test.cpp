#include "anatomesh/pipeline/model/quadratic_model.h"

#include <gtest/gtest.h>

#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::quadratic_model_test {
namespace {

using namespace fixtures;

double figure(const Model& model, const std::string& name) {
    for (const auto& [key, value] : model.report.run.stages.back().figures) {
        if (key == name) return value;
    }
    ADD_FAILURE() << "no figure " << name;
    return 0;
}

// A shell far from the origin: a ball in another one.
Drawing shell_drawing() {
    Drawing drawing;
    drawing.add_ball(0, {}, 20, 2, 2);
    drawing.add_ball(0, {}, 12, 2, 2);
    drawing.move([](Vec3 p) { return p + Vec3{300, -200, 1000}; });
    return drawing;
}

TEST(QuadraticModel, nodes_lie_on_the_field_and_on_the_segments) {
    const ContourSet set = kept(shell_drawing().raw);
    auto built = build(set);
    ASSERT_TRUE(built.ok());
    Model model = std::move(built).value();
    RunContext context;
    const auto made = quadratic_model(model, set, {}, context);
    ASSERT_TRUE(made.ok());
    const MidNodes& nodes = made.value();

    ASSERT_EQ(nodes.cells.size(), model.mesh.cells.size());
    std::size_t on = 0;
    for (std::size_t c = 0; c < nodes.cells.size(); ++c) {
        EXPECT_GE(least_jacobian(element_of(model.mesh, nodes, c)), QuadraticOptions{}.min_jacobian);
    }
    const MidNodes straight = straight_mid_nodes(model.mesh);
    for (std::size_t n = 0; n < nodes.points.size(); ++n) {
        if (nodes.points[n] == straight.points[n]) continue;
        on += std::abs(model.field->value(0, nodes.points[n] - model.field_origin)) < 1e-5;
    }
    EXPECT_GT(on, 1000u);
    EXPECT_LE(static_cast<double>(on), figure(model, "on_interface"));
    EXPECT_LT(figure(model, "pulled_back") + figure(model, "straightened"),
              0.02 * figure(model, "on_interface"));
    EXPECT_EQ(figure(model, "mid_nodes"), static_cast<double>(nodes.points.size()));

    // Nodes of contour segments are their middles.
    EXPECT_GE(figure(model, "segment_nodes"), 0.9 * static_cast<double>(set.points.size()));
    std::vector<VertexPair> segments;
    for (const Contour& contour : set.contours) {
        for (std::uint32_t k = 0; k < contour.point_count; ++k) {
            segments.push_back({model.contour_vertices[contour.first_point + k],
                                model.contour_vertices[contour.first_point + (k + 1) % contour.point_count]});
        }
    }
    const auto edges =
        edges_along(model.mesh, cell_neighbors(model.mesh.cells, model.mesh.points.size()), segments);
    std::size_t found = 0;
    for (std::size_t c = 0; c < nodes.cells.size(); ++c) {
        for (std::size_t e = 0; e < 6; ++e) {
            std::uint32_t a = model.mesh.cells[c][static_cast<std::size_t>(cell_edges[e][0])];
            std::uint32_t b = model.mesh.cells[c][static_cast<std::size_t>(cell_edges[e][1])];
            if (a > b) std::swap(a, b);
            if (!std::binary_search(edges.begin(), edges.end(), VertexPair{a, b})) continue;
            ++found;
            EXPECT_EQ(nodes.points[nodes.cells[c][e]], 0.5 * (model.mesh.points[a] + model.mesh.points[b]));
        }
    }
    EXPECT_GT(found, edges.size());
}

TEST(QuadraticModel, is_nearer_to_the_field_than_the_linear_model) {
    Drawing drawing;
    drawing.add_ball(0, {}, 15, 2, 3);
    const ContourSet set = kept(drawing.raw);
    auto built = build(set);
    ASSERT_TRUE(built.ok());
    Model model = std::move(built).value();
    RunContext context;
    const auto made = quadratic_model(model, set, {}, context);
    ASSERT_TRUE(made.ok());
    // Centroids of the boundary facets, flat and curved, by their distance from the field's surface.
    double flat = 0, curved = 0;
    const std::vector<std::uint32_t> neighbors = cell_neighbors(model.mesh.cells, model.mesh.points.size());
    for (std::size_t c = 0; c < model.mesh.cells.size(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (neighbors[4 * c + i] != no_cell) continue;
            Vec3 corners, mids;
            for (const int k : facet_vertices[i])
                corners += model.mesh.points[model.mesh.cells[c][static_cast<std::size_t>(k)]];
            for (std::size_t e = 0; e < 6; ++e) {
                const auto [a, b] = cell_edges[e];
                if (static_cast<std::size_t>(a) == i || static_cast<std::size_t>(b) == i) continue;
                mids += made.value().points[made.value().cells[c][e]];
            }
            flat += std::abs(model.field->value(0, (1.0 / 3) * corners - model.field_origin));
            curved +=
                std::abs(model.field->value(0, (4.0 / 9) * mids - (1.0 / 9) * corners - model.field_origin));
        }
    }
    EXPECT_LT(curved, 0.6 * flat);
}

}  // namespace
}  // namespace anatomesh::quadratic_model_test
