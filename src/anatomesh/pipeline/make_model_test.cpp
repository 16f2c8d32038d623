// The one call of the library, beside its two halves, and what each option of preparing does.
#include "anatomesh/pipeline/make_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "anatomesh/pipeline/drawn_balls_for_test.h"

namespace anatomesh::make_model_test {
namespace {

using fixtures::DrawnSet;

MakeModelOptions options_for(const DrawnSet& drawn) {
    MakeModelOptions options;
    options.prepare.priority = drawn.priority;
    options.size_mm = 2;
    return options;
}

void expect_same_mesh(const Model& a, const Model& b) {
    EXPECT_EQ(a.mesh.points, b.mesh.points);
    EXPECT_EQ(a.mesh.cells, b.mesh.cells);
    EXPECT_EQ(a.mesh.regions, b.mesh.regions);
    EXPECT_EQ(a.regions.members, b.regions.members);
    EXPECT_EQ(a.contours.points, b.contours.points);
    EXPECT_EQ(a.routed, b.routed);
}

std::vector<std::string> values_of(const std::vector<std::pair<std::string, std::string>>& options,
                                   const std::string& name) {
    std::vector<std::string> values;
    for (const auto& [each, value] : options) {
        if (each == name) values.push_back(value);
    }
    return values;
}

class OneCall : public ::testing::TestWithParam<DrawnSet> {};

TEST_P(OneCall, equals_its_two_halves) {
    const MakeModelOptions options = options_for(GetParam());
    RunContext once, halves;
    const auto whole = make_model(GetParam().raw, options, once);
    ASSERT_TRUE(whole.ok()) << to_line(whole.error());
    const auto prepared = prepare_contours(GetParam().raw, options.prepare, halves);
    ASSERT_TRUE(prepared.ok()) << to_line(prepared.error());
    const auto built = build_model(prepared.value().kept, model_options(options), halves);
    ASSERT_TRUE(built.ok()) << to_line(built.error());
    expect_same_mesh(whole.value(), built.value());
    EXPECT_EQ(whole.value().drawn.points, prepared.value().kept.points);
    ASSERT_EQ(once.warnings.size(), halves.warnings.size());
    for (std::size_t w = 0; w < once.warnings.size(); ++w)
        EXPECT_EQ(to_line(once.warnings[w]), to_line(halves.warnings[w]));
    EXPECT_EQ(whole.value().report.warnings.size(), once.warnings.size());
}

TEST_P(OneCall, is_the_same_at_any_thread_count) {
    RunContext one, three;
    three.threads = 3;
    const auto a = make_model(GetParam().raw, options_for(GetParam()), one);
    const auto b = make_model(GetParam().raw, options_for(GetParam()), three);
    ASSERT_TRUE(a.ok() && b.ok());
    expect_same_mesh(a.value(), b.value());
}

// Cleaned by the caller, the rest by the call.
TEST_P(OneCall, of_cleaned_contours_is_the_same_model) {
    const MakeModelOptions options = options_for(GetParam());
    RunContext raw, cleaned;
    const auto whole = make_model(GetParam().raw, options, raw);
    auto kept = clean_contours(GetParam().raw, options.prepare.clean, cleaned);
    ASSERT_TRUE(whole.ok() && kept.ok());
    const auto half = make_model(std::move(kept).value().kept, options, cleaned);
    ASSERT_TRUE(half.ok()) << to_line(half.error());
    expect_same_mesh(whole.value(), half.value());
}

TEST_P(OneCall, tells_crossing_slices_and_priority) {
    RunContext context;
    const auto made = make_model(GetParam().raw, options_for(GetParam()), context);
    ASSERT_TRUE(made.ok());
    const ModelReport& report = made.value().report;
    const bool crosses = GetParam().name.starts_with("crossing");
    EXPECT_EQ(report.crossing.pairs.empty(), !crosses);
    EXPECT_EQ(values_of(report.provenance.options, "reconcile"),
              crosses ? std::vector<std::string>{"1"} : std::vector<std::string>{});
    if (crosses) {
        EXPECT_GT(report.crossing.difference_mm, report.crossing.difference_after_mm);
    }
    EXPECT_EQ(values_of(report.provenance.options, "priority").size(),
              GetParam().priority.empty() ? 0 : report.structures.size());
    EXPECT_EQ(made.value().drawn.exclusive, !GetParam().priority.empty());
    EXPECT_EQ(report.contours.log.size(), GetParam().raw.contours.size());
    ASSERT_GE(report.run.stages.size(), 2u);
    EXPECT_EQ(report.run.stages[0].name, "contours");
    EXPECT_EQ(report.run.stages[1].name, "reconcile");
}

INSTANTIATE_TEST_SUITE_P(sets, OneCall, ::testing::ValuesIn(fixtures::drawn_sets()),
                         [](const auto& tested) { return tested.param.name; });

DrawnSet set_of(const std::string& name) {
    for (DrawnSet& set : fixtures::drawn_sets()) {
        if (set.name == name) return set;
    }
    ADD_FAILURE() << name;
    return {};
}

PreparedContours prepared(const RawContours& raw, const PrepareOptions& options) {
    RunContext context;
    auto result = prepare_contours(raw, options, context);
    EXPECT_TRUE(result.ok()) << to_line(result.error());
    return std::move(result).value();
}

std::string code_of(const RawContours& raw, const PrepareOptions& options) {
    RunContext context;
    const auto result = prepare_contours(raw, options, context);
    return result.ok() ? "" : result.error().code;
}

TEST(PrepareContours, goes_no_further_than_asked) {
    const DrawnSet drawn = set_of("shared_wall");
    PrepareOptions options;
    options.until = PrepareUntil::chosen;
    const PreparedContours chosen = prepared(drawn.raw, options);
    EXPECT_EQ(chosen.kept.points.size(), drawn.raw.points.size());
    EXPECT_EQ(chosen.stages.size(), 1u);
    EXPECT_TRUE(values_of(chosen.options, "same_line_mm").empty());
    options.until = PrepareUntil::walls;
    const PreparedContours shared = prepared(drawn.raw, options);
    EXPECT_NE(shared.kept.points, chosen.kept.points) << "copies of one line share its vertices";
    EXPECT_EQ(shared.stages.size(), 1u);

    const DrawnSet crossing = set_of("crossing");
    EXPECT_EQ(prepared(crossing.raw, options).crossing.pairs.size(), 0u);
    options.until = PrepareUntil::all;
    EXPECT_GT(prepared(crossing.raw, options).crossing.pairs.size(), 0u);
}

TEST(PrepareContours, chooses_structures_and_slices) {
    const DrawnSet drawn = set_of("parallel");
    PrepareOptions options;
    options.choice.structures = {"right"};
    PreparedContours one = prepared(drawn.raw, options);
    ASSERT_EQ(one.kept.structures.size(), 1u);
    EXPECT_EQ(one.kept.structures[0].number, 2);
    EXPECT_EQ(values_of(one.options, "structure"), std::vector<std::string>{"right"});
    options.choice.structures = {"1", "2"};
    const PreparedContours both = prepared(drawn.raw, options);
    EXPECT_EQ(both.kept.points, prepared(drawn.raw, {}).kept.points);
    options.choice.every = 2;
    options.choice.offset = 1;
    EXPECT_EQ(prepared(drawn.raw, options).kept.slices.size(), both.kept.slices.size() / 2);
    options = {};
    options.choice.without = {both.kept.slices[1].name};
    EXPECT_EQ(prepared(drawn.raw, options).kept.slices.size(), both.kept.slices.size() - 1);
    options = {};
    options.epsilon_mm = 0.5;
    EXPECT_LT(prepared(drawn.raw, options).kept.points.size(), both.kept.points.size());
}

TEST(PrepareContours, refuses_what_does_not_apply) {
    PrepareOptions options;
    options.choice.structures = {"spleen"};
    EXPECT_EQ(code_of(set_of("parallel").raw, options), "E-CMD-005");
    options = {};
    options.priority = {"spleen"};
    EXPECT_EQ(code_of(set_of("parallel").raw, options), "E-CMD-005");
    options = {};
    options.choice.every = 2;
    EXPECT_EQ(code_of(set_of("crossing").raw, options), "E-CMD-008") << "no order";
    options.choice.every = 100;
    options.choice.offset = 99;
    EXPECT_EQ(code_of(set_of("parallel").raw, options), "E-CMD-008") << "none left";
    options = {};
    options.choice.structures = {"left"};
    options.walls.close_gaps_mm = 1;
    EXPECT_EQ(code_of(set_of("parallel").raw, options), "E-CMD-008") << "one structure";
    RawContours spaces = set_of("parallel").raw;
    for (RawContour& contour : spaces.contours) contour.space = 1 + contour.structure;
    EXPECT_EQ(code_of(spaces, {}), "E-RTS-010");
    options = {};
    options.take_spaces_for_one = true;
    EXPECT_EQ(code_of(spaces, options), "");
    options.choice.structures = {"left"};
    options.take_spaces_for_one = false;
    EXPECT_EQ(code_of(spaces, options), "") << "those of one space";
}

TEST(PrepareContours, a_check_sees_the_contours_before_they_move) {
    const DrawnSet drawn = set_of("crossing");
    PrepareOptions options;
    options.until = PrepareUntil::walls;
    const PreparedContours before = prepared(drawn.raw, options);
    options.until = PrepareUntil::all;
    RunContext context;
    int calls = 0;
    const auto check = [&](const ContourSet& kept) -> Status {
        ++calls;
        EXPECT_EQ(kept.points, before.kept.points);
        return Error{ErrorKind::usage, "E-TST-001", "refused", {}, ""};
    };
    const auto refused = prepare_contours(drawn.raw, options, context, check);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, "E-TST-001");
    options.until = PrepareUntil::walls;
    EXPECT_TRUE(prepare_contours(drawn.raw, options, context, check).ok());
    EXPECT_EQ(calls, 1);
}

TEST(PrepareContours, kept_as_drawn_where_slices_need_not_agree) {
    const DrawnSet drawn = set_of("crossing");
    MakeModelOptions options;
    options.prepare.reconcile.reconcile = false;
    EXPECT_EQ(model_options(options).max_reroute_mm, 0);
    const PreparedContours measured = prepared(drawn.raw, options.prepare);
    options.prepare.until = PrepareUntil::walls;
    EXPECT_EQ(measured.kept.points, prepared(drawn.raw, options.prepare).kept.points);
    EXPECT_FALSE(measured.crossing.reconciled);
    EXPECT_GT(measured.crossing.pairs.size(), 0u);
    options = {};
    EXPECT_EQ(model_options(options).max_reroute_mm, ReconcileOptions{}.max_disagreement_mm);
}

TEST(PrepareContours, cleaning_is_told_where_it_is_not_the_usual_one) {
    const DrawnSet drawn = set_of("parallel");
    PrepareOptions options;
    EXPECT_TRUE(values_of(prepared(drawn.raw, options).options, "holes").empty());
    options.name_cleaning = true;
    EXPECT_EQ(values_of(prepared(drawn.raw, options).options, "holes"), std::vector<std::string>{"even-odd"});
    options.name_cleaning = false;
    options.clean.rings.holes = HoleRule::united;
    EXPECT_EQ(values_of(prepared(drawn.raw, options).options, "holes"), std::vector<std::string>{"filled"});
    options = {};
    options.walls.close_gaps_mm = 0.5;
    EXPECT_EQ(values_of(prepared(drawn.raw, options).options, "close_gaps_mm"),
              std::vector<std::string>{"0.5"});
    EXPECT_FALSE(values_of(prepared(drawn.raw, options).options, "holes").empty());
}

// A cube of voxels beside another one, in one label map or in two.
LabelMap cubes(std::uint16_t labels) {
    LabelMap map;
    map.geometry.size = {24, 14, 10};
    map.voxels.assign(map.geometry.voxel_count(), 0);
    for (std::int32_t s = 1; s <= labels; ++s) map.structures.push_back({s, "cube " + std::to_string(s), {}});
    for (std::uint32_t k = 2; k < 8; ++k) {
        for (std::uint32_t j = 3; j < 11; ++j) {
            for (std::uint32_t i = 3; i < 21; ++i) {
                const auto label = static_cast<std::uint16_t>(i < 12 ? 1 : 2);
                if (label <= labels) map.voxels[map.geometry.index(i, j, k)] = label;
            }
        }
    }
    return map;
}

TEST(PrepareContours, label_maps_are_traced) {
    RunContext context;
    const auto both = prepare_contours({cubes(2)}, nullptr, {}, context);
    ASSERT_TRUE(both.ok()) << to_line(both.error());
    EXPECT_EQ(both.value().kept.structures.size(), 2u);
    EXPECT_TRUE(both.value().kept.exclusive);
    EXPECT_GT(both.value().traced_points, both.value().kept.points.size());
    EXPECT_GT(both.value().epsilon_mm, 0);
    const auto traced = trace_contours(cubes(2), nullptr, 0, trace_options({}), context);
    ASSERT_TRUE(traced.ok());
    EXPECT_EQ(both.value().kept.points, traced.value().kept.points);

    PrepareOptions options;
    options.choice.structures = {"cube 1"};
    const auto one = prepare_contours({cubes(2)}, nullptr, options, context);
    const auto alone = prepare_contours({cubes(1)}, nullptr, {}, context);
    ASSERT_TRUE(one.ok() && alone.ok());
    EXPECT_EQ(one.value().kept.points, alone.value().kept.points);
    LabelMap second = cubes(1);
    second.structures[0].number = 7;
    const auto layers = prepare_contours({cubes(1), second}, nullptr, {}, context);
    ASSERT_TRUE(layers.ok());
    EXPECT_EQ(layers.value().kept.structures.size(), 2u);
    EXPECT_FALSE(layers.value().kept.exclusive) << "layers may overlap";
}

}  // namespace
}  // namespace anatomesh::make_model_test
