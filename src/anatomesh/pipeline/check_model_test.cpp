#include "anatomesh/pipeline/check_model.h"

#include <gtest/gtest.h>

#include "anatomesh/mesh/stars/star.h"
#include "anatomesh/pipeline/grey_of_model.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"

namespace anatomesh::check_model_test {
namespace {

// Two balls in parallel slices: a model, and its contours.
struct Made {
    ContourSet contours;
    Model model;
};

Made two_balls() {
    fixtures::Drawing drawing;
    drawing.add_ball(0, {-12, 0, 0}, 9, 3, 2);
    drawing.add_ball(1, {12, 1, 0}, 8, 3, 2);
    Made made{fixtures::kept(drawing.raw), {}};
    Result<Model> model = fixtures::build(made.contours);
    EXPECT_TRUE(model.ok());
    if (model.ok()) made.model = std::move(model.value());
    return made;
}

std::size_t count(const RunContext& context, const std::string& code) {
    std::size_t found = 0;
    for (const Warning& warning : context.warnings) found += warning.code == code;
    return found;
}

TEST(CheckModel, FindsOfAModelWhatItsOwnReportSays) {
    const Made made = two_balls();
    const Model& model = made.model;
    CertificateInput input{model.mesh, model.regions, model.structures};
    input.contours = &made.contours;
    input.made_by_this_run = false;
    RunContext context;
    ModelReport report;
    check_model(input, {model.report.lengths.size_mm, nullptr, "drawn.json", "model.vtu"}, context, report);
    EXPECT_EQ(report.lengths.size_mm, model.report.lengths.size_mm);
    EXPECT_EQ(report.counts.tetrahedra, model.mesh.cells.size());
    ASSERT_EQ(report.structures.size(), 2u);
    for (std::size_t s = 0; s < 2; ++s) {
        EXPECT_EQ(report.structures[s].surface.genus, model.report.structures[s].surface.genus);
        EXPECT_EQ(report.structures[s].fidelity.segments_on_surface,
                  model.report.structures[s].fidelity.segments_on_surface);
    }
    EXPECT_FALSE(any_broken(report.certificate));
    EXPECT_EQ(count(context, "W-PIP-004"), 0u);
    EXPECT_EQ(count(context, "W-ELM-002"), 0u);
}

// Contours beside the surface, of a model that is one structure all over.
TEST(CheckModel, ContoursOffTheSurfaceBreakAClause) {
    Made made = two_balls();
    for (Region& region : made.model.mesh.regions) region = 1;
    for (Vec3& p : made.contours.points) p.x += 0.5;
    CertificateInput input{made.model.mesh, made.model.regions, made.model.structures};
    input.contours = &made.contours;
    input.made_by_this_run = false;
    RunContext context;
    ModelReport report;
    check_model(input, {}, context, report);
    EXPECT_TRUE(any_broken(report.certificate));
    EXPECT_EQ(report.lengths.size_mm, 0);
}

TEST(CheckModel, FoldedElementsAreWarnedOf) {
    TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}, {1}};
    MidNodes mid_nodes;
    mid_nodes.cells.push_back({0, 1, 2, 3, 4, 5});
    for (const auto& [a, b] : cell_edges)
        mid_nodes.points.push_back(0.5 * (mesh.points[mesh.cells[0][a]] + mesh.points[mesh.cells[0][b]]));
    const RegionTable regions{{{}, {0}}};
    const std::vector<Structure> structures{{1, "one", {}}};
    for (const bool folded : {false, true}) {
        if (folded) mid_nodes.points[0] = {3, 3, 3};
        RunContext context;
        ModelReport report;
        check_model({mesh, regions, structures}, {1, &mid_nodes, "", "model.vtu"}, context, report);
        ASSERT_EQ(count(context, "W-ELM-002"), folded ? 1u : 0u);
        if (folded) {
            EXPECT_EQ(context.warnings.back().place.file, "model.vtu");
        }
    }
}

TEST(GreyOfModel, SaysHowManyTetrahedraLieOutside) {
    GreyImage image;
    image.geometry.size = {4, 4, 4};
    image.voxels.assign(64, 7.0F);
    const TetMesh mesh{
        {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {90, 0, 0}, {92, 0, 0}, {90, 2, 0}, {90, 0, 2}},
        {{0, 1, 2, 3}, {4, 5, 6, 7}},
        {1, 1}};
    RunContext context;
    const Result<GreyOfModel> grey = grey_of_model(mesh, image, "image.nii", context);
    ASSERT_TRUE(grey.ok());
    EXPECT_EQ(grey.value().values, (std::vector<double>{7, 7}));
    EXPECT_EQ(grey.value().stage.name, "grey");
    EXPECT_EQ(grey.value().stage.cells, 2u);
    ASSERT_EQ(count(context, "W-ELM-001"), 1u);
    EXPECT_EQ(context.warnings.back().place.file, "image.nii");
}

}  // namespace
}  // namespace anatomesh::check_model_test
