// anatomesh contours: the contours of an image, label map or contour file.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh/base/plural.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/dicom/write_objects.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/report/options_json.h"
#include "answer.h"
#include "dicom_input.h"
#include "help_text.h"
#include "input_options.h"
#include "option_values.h"
#include "outputs.h"
#include "read_input.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct ContoursOptions {
    InputOptions input;
    std::string output, report;  // report empty: none
};

// How every drawn contour was read, as in the report of a model.
nlohmann::ordered_json log_json(const std::vector<ContourReport>& log) {
    auto list = nlohmann::ordered_json::array();
    for (const ContourReport& contour : log) {
        list.push_back({{"structure", contour.structure},
                        {"slice", contour.slice},
                        {"name", contour.name},
                        {"rule", contour.rule},
                        {"points_in", contour.points_in},
                        {"points_kept", contour.points_kept},
                        {"max_displacement_mm", contour.max_displacement_mm},
                        {"area_change_mm2", contour.area_change_mm2}});
    }
    return list;
}

nlohmann::ordered_json answer_of(const InputContours& contours, const std::string& output) {
    const ContourSet& kept = contours.kept;
    nlohmann::ordered_json answer;
    answer["version"] = ANATOMESH_VERSION;
    answer["output"] = output;
    answer["inputs"] = inputs_json(contours.files);
    answer["options"] = options_json(contours.options);
    answer["structures"] = kept.structures.size();
    answer["slices"] = kept.slices.size();
    answer["contours"] = kept.contours.size();
    answer["points"] = kept.points.size();
    answer["points_before_simplification"] = contours.traced_points;
    answer["islands_left_out"] = contours.islands_left_out;
    return answer;
}

Status check_names(const ContoursOptions& options) {
    ANATOMESH_CHECK_STATUS(check_extension(options.output, {".json", ".vtp", ".csl", ".dcm"}));
    std::vector<std::string> outputs{options.output};
    if (!options.report.empty()) {
        ANATOMESH_CHECK_STATUS(check_extension(options.report, {".json"}));
        outputs.push_back(options.report);
    }
    return check_outputs({options.input.input}, outputs);
}

Result<std::string> file_of(const InputContours& contours, const ContoursOptions& options,
                            RunContext& context) {
    if (!check_extension(options.output, {".dcm"}).ok()) {
        ANATOMESH_TRY(const ContourFormat format, contour_format_of(options.output));
        return format_contours(contours.kept, format, context);
    }
    if (contours.kept.frame != Frame::lps)
        return Error{ErrorKind::usage,
                     "E-CMD-018",
                     "the axes of the contours are unknown, and DICOM needs them",
                     {options.input.input, "", "", "", ""},
                     "give --frame LPS or --frame RAS"};
    ANATOMESH_TRY(const DicomSource source, output_source(options.input, contours.dicom_source, context));
    return format_rtstruct(contours.kept, source);
}

Status run_contours(ContoursOptions options, Session& session) {
    options.input.limits = session.limits;
    options.input.prepare.until = PrepareUntil::walls;
    ANATOMESH_CHECK_STATUS(check_names(options));
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, session.context));
    ANATOMESH_CHECK_STATUS(check_outputs(
        names_of(opened.files),
        options.report.empty() ? std::vector{options.output} : std::vector{options.output, options.report}));
    ANATOMESH_TRY(const InputContours contours,
                  contours_of(std::move(opened), options.input, session.context));
    if (session.context.cancelled()) return cancelled_error();

    const ContourSet& kept = contours.kept;
    AtomicFileSet files;
    ANATOMESH_TRY(const std::string bytes, file_of(contours, options, session.context));
    ANATOMESH_CHECK_STATUS(files.add(options.output, bytes));
    const nlohmann::ordered_json answer = answer_of(contours, options.output);
    if (!options.report.empty()) {
        nlohmann::ordered_json report = answer;
        report["contour_log"] = log_json(contours.log);
        ANATOMESH_CHECK_STATUS(files.add(options.report, json_text(session, std::move(report))));
    }
    return files.commit([&] {
        return give_summary(
            session, answer,
            fmt::format("{}: {} on {}, {} (of {})\n", options.output,
                        counted(kept.contours.size(), "contour"), counted(kept.slices.size(), "slice"),
                        counted(kept.points.size(), "point"), contours.traced_points));
    });
}

}  // namespace

Work declare_contours(CLI::App& verb) {
    auto options = std::make_shared<ContoursOptions>();
    add_reading_options(verb, options->input);
    add_selection_options(verb, options->input);
    add_cleaning_options(verb, options->input);
    add_text(verb, "-o,--output", options->output, "OUT",
             "The contours to write: .json, .vtp, .csl or .dcm (RTSTRUCT).")
        ->required();
    add_text(verb, "--report", options->report, "FILE",
             "Also write a report on what was read, with all warnings: .json.");
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_contours(*options, session); };
}

}  // namespace anatomesh
