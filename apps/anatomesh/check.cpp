// anatomesh check: the certificate of any model.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh/measure/certificate.h"
#include "anatomesh_io/report/report_json.h"
#include "answer.h"
#include "mesh_input.h"
#include "option_values.h"
#include "read_input.h"
#include "summary.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct CheckOptions {
    std::string model;
    InputOptions contours;  // input empty: none
};

Status run_check(const CheckOptions& options, Session& session) {
    ANATOMESH_TRY(const ModelFile model, read_model(options.model, session.context));
    std::optional<InputContours> contours;
    ModelReport report;
    if (!options.contours.input.empty()) {
        ANATOMESH_TRY(OpenedInput opened, open_input(options.contours, session.context));
        ANATOMESH_TRY(contours, contours_of(std::move(opened), options.contours, session.context));
        report.inputs = contours->files;
    }
    CertificateInput input{model.mesh, model.description.regions, model.description.structures};
    input.contours = contours ? &contours->kept : nullptr;
    input.made_by_this_run = false;
    measure_model(input, session.context, report);
    report.version = ANATOMESH_VERSION;
    report.command = session.command;
    report.space = model.description.space;
    report.unit = model.description.unit;
    report.warnings = session.context.warnings;

    const std::string text = options.model + "\n" + report_summary(report) + certificate_text(report);
    ANATOMESH_CHECK_STATUS(session.json ? print_answer(report_json(report)) : print_answer(printable(text)));
    if (!any_broken(report.certificate)) return Nothing{};
    const auto broken =
        std::count_if(report.certificate.begin(), report.certificate.end(),
                      [](const Clause& clause) { return clause.state == ClauseState::broken; });
    return Error{ErrorKind::geometry,
                 "E-CMD-013",
                 fmt::format("the model breaks {} of the clauses", broken),
                 {options.model, "", "", "", ""},
                 "the certificate above says which and where"};
}

}  // namespace

Work declare_check(CLI::App& verb) {
    auto options = std::make_shared<CheckOptions>();
    verb.add_option("MODEL", options->model, "Tetrahedral model of any format that is read")
        ->type_name("FILE")
        ->required();
    add_text(verb, "--contours", options->contours.input, "FILE",
             "Contours whose vertices must be on the surface");
    add_choice(verb, "--frame", options->contours.frame, {"LPS", "RAS"},
               "Axes of the coordinates in a contour file that does not say");
    return [options](Session& session) { return run_check(*options, session); };
}

}  // namespace anatomesh
