// anatomesh where-next: the planes on which one more contour would tell most.
#include "anatomesh/uncertainty/where_next.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "anatomesh/pipeline/make_model.h"
#include "anatomesh/uncertainty/left_out.h"
#include "anatomesh/uncertainty/surface_uncertainty.h"
#include "answer.h"
#include "field_options.h"
#include "help_text.h"
#include "input_options.h"
#include "option_values.h"
#include "read_input.h"
#include "reconcile_options.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct WhereNextVerbOptions {
    InputOptions input;
    double size_mm = MakeModelOptions{}.size_mm;
    WhereNextOptions choosing;
};

std::string slice_name(const ContourSet& kept, std::int64_t slice) {
    const std::string& name = kept.slices[static_cast<std::size_t>(slice)].name;
    return name.empty() ? fmt::format("slice {}", slice) : name;
}

std::string place_of(const ContourSet& kept, const NextPlane& next) {
    if (next.slice_b < 0) return "beside " + slice_name(kept, next.slice_a);
    return fmt::format("between {} and {}{}", slice_name(kept, next.slice_a), slice_name(kept, next.slice_b),
                       next.gap_mm3 > 0 ? ", where slices are missing" : "");
}

nlohmann::ordered_json plane_json(const ContourSet& kept, const NextPlane& next) {
    const Vec3 origin = next.plane.origin, normal = next.plane.normal;
    nlohmann::ordered_json plane{{"place", place_of(kept, next)},
                                 {"origin_mm", {origin.x, origin.y, origin.z}},
                                 {"normal", {normal.x, normal.y, normal.z}},
                                 {"gain_mm3", next.gain_mm3},
                                 {"gap_mm3", next.gap_mm3},
                                 {"expected_error_mm", next.expected_mm}};
    nlohmann::ordered_json structures = nlohmann::ordered_json::array();
    for (std::size_t s = 0; s < next.gain_by_structure.size(); ++s) {
        if (!(next.gain_by_structure[s] > 0)) continue;
        structures.push_back({{"number", kept.structures[s].number},
                              {"name", kept.structures[s].name},
                              {"gain_mm3", next.gain_by_structure[s]}});
    }
    plane["structures"] = std::move(structures);
    return plane;
}

nlohmann::ordered_json slices_json(const ContourSet& kept, const LeftOut& errors) {
    nlohmann::ordered_json slices = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < errors.slices.size(); ++k) {
        const SliceError& error = errors.slices[k];
        if (error.points == 0) continue;
        slices.push_back({{"slice", slice_name(kept, static_cast<std::int64_t>(k))},
                          {"points", error.points},
                          {"mean_mm", error.mean_mm},
                          {"p95_mm", error.p95_mm},
                          {"max_mm", error.max_mm}});
    }
    return slices;
}

std::string table_of(const ContourSet& kept, const WhereNext& next) {
    std::string text = fmt::format("{:>4} {:>10} {:>9}  {:<26} {:<34} {}\n", "", "gain, mm3", "error, mm",
                                   "normal", "through", "place");
    for (std::size_t n = 0; n < next.planes.size(); ++n) {
        const NextPlane& plane = next.planes[n];
        const Vec3 o = plane.plane.origin, d = plane.plane.normal;
        text += fmt::format("{:>4} {:>10.1f} {:>9.3f}  {:<26} {:<34} {}\n", n + 1, plane.gain_mm3,
                            plane.expected_mm, fmt::format("{:.3f} {:.3f} {:.3f}", d.x, d.y, d.z),
                            fmt::format("{:.2f} {:.2f} {:.2f}", o.x, o.y, o.z), place_of(kept, plane));
    }
    text +=
        fmt::format("expected error on the whole surface: {:.1f} mm3\n", next.expected_mm3 - next.gaps_mm3);
    if (next.gaps_mm3 > 0) {
        text += fmt::format(
            "expected error where slices are missing and the two sides are not joined: {:.1f} mm3\n",
            next.gaps_mm3);
    }
    return text;
}

Status run_where_next(WhereNextVerbOptions options, Session& session) {
    RunContext& context = session.context;
    options.input.limits = session.limits;
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    const auto check = [&](const ContourSet& kept) { return check_reconcile_options(kept, options.input); };
    ANATOMESH_TRY(const InputContours contours,
                  contours_of(std::move(opened), options.input, context, check));
    MakeModelOptions making;
    making.prepare = options.input.prepare;
    making.size_mm = options.size_mm;
    making.max_tetrahedra = session.limits.tetrahedra;
    ANATOMESH_TRY(const Model model, build_model(contours.kept, model_options(making), context));
    LeftOutOptions leaving;
    leaving.field = making.prepare.field;
    ANATOMESH_TRY(const LeftOut errors, leave_slices_out(contours.kept, leaving, context));
    const SurfaceUncertainty uncertainty =
        surface_uncertainty(contours.kept, errors, model.mesh, model.regions, context);
    options.choosing.field = leaving.field;
    const WhereNext next =
        where_next(contours.kept, uncertainty, model.mesh, model.regions, options.choosing);
    nlohmann::ordered_json answer;
    answer["unit"] = "mm";
    answer["expected_error_mm3"] = next.expected_mm3;
    answer["expected_in_gaps_mm3"] = next.gaps_mm3;
    answer["planes"] = nlohmann::ordered_json::array();
    for (const NextPlane& plane : next.planes) answer["planes"].push_back(plane_json(contours.kept, plane));
    answer["left_out_slices"] = slices_json(contours.kept, errors);
    return give_answer(session, answer, table_of(contours.kept, next));
}

}  // namespace

Work declare_where_next(CLI::App& verb) {
    auto options = std::make_shared<WhereNextVerbOptions>();
    add_reading_options(verb, options->input);
    add_selection_options(verb, options->input);
    add_cleaning_options(verb, options->input);
    add_reconcile_options(verb, options->input);
    add_field_rule_options(verb, options->input.prepare.field);
    add_number(
        verb, "--size", options->size_mm, 0.01, 1000, "MM",
        "Edge length of the model that is examined, 0.01 to 1000 mm. Default: chosen from the contours.");
    group_new_options(verb, option_group::mesh);
    add_count(verb, "--count", options->choosing.count, 1, 1000,
              "How many planes to name, 1 to 1000. Default: 5.");
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_where_next(*options, session); };
}

}  // namespace anatomesh
