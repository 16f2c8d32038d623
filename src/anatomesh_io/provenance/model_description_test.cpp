#include "anatomesh_io/provenance/model_description.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "anatomesh/base/version.h"
#include "anatomesh/pipeline/drawn_balls_for_test.h"
#include "anatomesh/pipeline/make_model.h"
#include "anatomesh_io/provenance/routed_contour_notes.h"

namespace anatomesh::model_description_test {
namespace {

class ModelDescription : public ::testing::TestWithParam<fixtures::DrawnSet> {};

// What the notes say is what the model was made by.
TEST_P(ModelDescription, tells_options_and_warnings) {
    MakeModelOptions options;
    options.size_mm = 2.5;
    options.prepare.priority = GetParam().priority;
    RunContext context;
    const auto model = make_model(GetParam().raw, options, context);
    ASSERT_TRUE(model.ok()) << to_line(model.error());
    const ModelFile file = model_file(model.value());
    const MeshDescription& told = file.description;
    EXPECT_EQ(file.mesh.cells.size(), model.value().mesh.cells.size());
    EXPECT_EQ(told.structures.size(), model.value().structures.size());
    EXPECT_EQ(told.space, "LPS");
    ASSERT_FALSE(told.notes.empty());
    EXPECT_EQ(told.notes.front(), (std::pair<std::string, std::string>{"version", library_version()}));
    EXPECT_EQ(size_of(told), 2.5);
    EXPECT_EQ(option_of(told, "caps"), "half");
    EXPECT_EQ(number_of(told, "same_line_mm"), WallOptions{}.same_line_mm);
    EXPECT_FALSE(number_of(told, "caps")) << "no number";
    EXPECT_FALSE(option_of(told, "no such option"));
    const std::vector<std::string> order = options_of(told, "priority");
    if (!GetParam().priority.empty()) {
        ASSERT_EQ(order.size(), told.structures.size());
        EXPECT_EQ(order.front(),
                  GetParam().name == "crossing_first_vessel" ? "vessel" : GetParam().priority.front());
    }
    std::size_t warnings = 0;
    for (const auto& [key, value] : told.notes) {
        if (key == "warning") warnings += std::stoul(value.substr(value.find(' ') + 1));
    }
    EXPECT_EQ(warnings, context.warnings.size());
}

// Re-routed contours are read back from the notes as they were drawn, and as they lie on it.
TEST_P(ModelDescription, gives_back_contours_that_follow_the_surface) {
    MakeModelOptions options;
    options.size_mm = 2.5;
    options.prepare.priority = GetParam().priority;
    RunContext context;
    const auto made = make_model(GetParam().raw, options, context);
    ASSERT_TRUE(made.ok()) << to_line(made.error());
    const Model& model = made.value();
    const auto both = both_contours(model.drawn, description_of(model));
    EXPECT_EQ(both.has_value(), !model.routed.empty());
    if (!both) return;
    EXPECT_EQ(both->drawn.points, model.drawn.points);
    EXPECT_EQ(both->on_surface.points, model.contours.points);
    EXPECT_EQ(both->routed.size(), model.routed.size());
}

INSTANTIATE_TEST_SUITE_P(sets, ModelDescription, ::testing::ValuesIn(fixtures::drawn_sets()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace anatomesh::model_description_test
