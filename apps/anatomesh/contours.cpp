// anatomesh contours: the contours of an image, label map or contour file.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh_io/contour/write_contours.h"
#include "answer.h"
#include "input_options.h"
#include "option_values.h"
#include "outputs.h"
#include "read_input.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct ContoursOptions {
    InputOptions input;
    std::string output;
};

Status run_contours(const ContoursOptions& options, Session& session) {
    ANATOMESH_CHECK_STATUS(contour_format_of(options.output));
    ANATOMESH_CHECK_STATUS(check_outputs({options.input.input}, {options.output}));
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, session.context));
    ANATOMESH_TRY(const InputContours contours,
                  contours_of(std::move(opened), options.input, session.context));
    if (session.context.cancelled()) return cancelled_error();
    ANATOMESH_CHECK_STATUS(write_contours(contours.kept, options.output, session.context));

    const ContourSet& kept = contours.kept;
    nlohmann::ordered_json answer;
    answer["output"] = options.output;
    answer["inputs"] = inputs_json(contours.files);
    answer["options"] = nlohmann::ordered_json::object();
    for (const auto& [name, value] : contours.options) answer["options"][name] = value;
    answer["structures"] = kept.structures.size();
    answer["slices"] = kept.slices.size();
    answer["contours"] = kept.contours.size();
    answer["points"] = kept.points.size();
    answer["points_before_simplification"] = contours.traced_points;
    answer["islands_left_out"] = contours.islands_left_out;
    return give_summary(
        session, answer,
        fmt::format("{}: {} contours on {} slices, {} points (of {})\n", options.output, kept.contours.size(),
                    kept.slices.size(), kept.points.size(), contours.traced_points));
}

}  // namespace

Work declare_contours(CLI::App& verb) {
    auto options = std::make_shared<ContoursOptions>();
    add_reading_options(verb, options->input);
    add_selection_options(verb, options->input);
    add_text(verb, "-o,--output", options->output, "OUT", "File to write: .json, .vtp or .csl")->required();
    return [options](Session& session) { return run_contours(*options, session); };
}

}  // namespace anatomesh
