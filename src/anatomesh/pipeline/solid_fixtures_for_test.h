// For tests: models built from drawings, and what is expected of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/sample/drawing_for_test.h"

namespace anatomesh::fixtures {

inline Result<Model> build(const ContourSet& set, double size = 0, int threads = 1) {
    RunContext context;
    context.threads = threads;
    ModelOptions options;
    options.size_mm = size;
    return build_model(set, options, context);
}

// Clauses 1, 3 and 6 are kept, so is 4 but for a few cells, and every contour vertex is where it was.
inline void expect_certified(const Model& model, const ContourSet& set) {
    for (const int number : {1, 3, 4, 6}) {
        const auto& certificate = model.report.certificate;
        const auto clause = std::find_if(certificate.begin(), certificate.end(),
                                         [&](const Clause& c) { return c.number == number; });
        ASSERT_NE(clause, certificate.end());
        if (number == 4 && clause->state == ClauseState::not_promised_yet) {
            // Single cells with a small angle; none with a bad ratio that the contours do not force.
            EXPECT_EQ(clause->evidence.rfind("measured, not met: ", 0), 0u) << clause->evidence;
            for (const ListedCell& cell : model.report.listed_cells.cells) {
                EXPECT_TRUE(cell.value <= 4.1 || !cell.forced_by.empty()) << clause->evidence;
            }
            continue;
        }
        EXPECT_EQ(clause->state, ClauseState::kept) << clause->statement << ": " << clause->evidence;
    }
    ASSERT_EQ(model.contour_vertices.size(), set.points.size());
    for (std::size_t n = 0; n < set.points.size(); ++n) {
        ASSERT_LT(model.contour_vertices[n], model.mesh.points.size());
        EXPECT_EQ(model.mesh.points[model.contour_vertices[n]], set.points[n]);
    }
}

// What a structure of a model is expected to be.
struct Expected {
    std::uint32_t components = 1;  // of its surface
    std::int64_t genus = 0;
    double volume = 0;    // mm^3
    double share = 0.02;  // allowed relative difference from it
};

inline void expect_structure(const Model& model, std::size_t structure, const Expected& expected) {
    ASSERT_LT(structure, model.report.structures.size());
    const StructureReport& report = model.report.structures[structure];
    EXPECT_EQ(report.surface.components, expected.components) << report.name;
    EXPECT_EQ(report.surface.genus, expected.genus) << report.name;
    EXPECT_NEAR(report.volume.mesh_mm3, expected.volume, expected.share * expected.volume) << report.name;
}

// Builds the model of a drawing and checks its certificate.
inline Model certified_model(const Drawing& drawing, double size = 0, bool exclusive = false) {
    const ContourSet set = kept(drawing.raw, exclusive);
    auto made = build(set, size);
    if (!made.ok()) {
        ADD_FAILURE() << to_line(made.error());
        return {};
    }
    expect_certified(made.value(), set);
    return std::move(made).value();
}

// The same cells of the same points and regions, bit for bit.
inline void expect_same_mesh(const Model& a, const Model& b) {
    EXPECT_EQ(a.mesh.points, b.mesh.points);
    EXPECT_EQ(a.mesh.cells, b.mesh.cells);
    EXPECT_EQ(a.mesh.regions, b.mesh.regions);
    EXPECT_EQ(a.regions.members, b.regions.members);
}

}  // namespace anatomesh::fixtures
