// anatomesh check: the certificate of any model.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "anatomesh/base/plural.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/pipeline/check_model.h"
#include "anatomesh_io/provenance/contours_of_model.h"
#include "anatomesh_io/provenance/field_of_model.h"
#include "anatomesh_io/provenance/model_description.h"
#include "anatomesh_io/report/report_json.h"
#include "answer.h"
#include "command_words.h"
#include "help_text.h"
#include "mesh_input.h"
#include "option_values.h"
#include "read_input.h"
#include "report_names.h"
#include "summary.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct CheckOptions {
    std::string model;
    InputOptions contours;  // input empty: none
};

// Whether two sets of points span the same box but for turned x and y, as one set in LPS and in RAS does.
bool are_turned(const Box3& a, const Box3& b) {
    const double near = 0.01 * std::max(a.diagonal(), b.diagonal());
    const auto match = [&](double p, double q) { return std::abs(p - q) <= near; };
    const bool same = match(a.low.x, b.low.x) && match(a.high.x, b.high.x) && match(a.low.y, b.low.y) &&
                      match(a.high.y, b.high.y);
    return !same && match(a.low.x, -b.high.x) && match(a.high.x, -b.low.x) && match(a.low.y, -b.high.y) &&
           match(a.high.y, -b.low.y);
}

Box3 box_of(const std::vector<Vec3>& points) {
    Box3 box;
    for (const Vec3& p : points) box.extend(p);
    return box;
}

// What a model's file says of contours that became one line is believed up to this: it alone does not make
// contours wider apart the same. [mm; > 0; C]
constexpr double widest_told_mm = 1;

// Whether the user says how walls are shared.
bool walls_are_given(const InputOptions& options) {
    return std::any_of(
        options.cleaning_given.begin(), options.cleaning_given.end(), [](const std::string& name) {
            return name == "--same-line" || name == "--close-slivers" || name == "--close-gaps";
        });
}

// What the user can do about broken clauses.
std::string advice(const CheckOptions& options, const ModelFile& model, const InputContours* contours,
                   const ModelReport& report) {
    const auto broken = [&](int number) {
        return std::any_of(report.certificate.begin(), report.certificate.end(), [&](const Clause& clause) {
            return clause.number == number && clause.state == ClauseState::broken;
        });
    };
    if (broken(1) && contours && contours->kept.frame == Frame::unknown && options.contours.frame.empty() &&
        model.description.space == "LPS") {
        const bool turned = are_turned(box_of(contours->kept.points), box_of(model.mesh.points));
        return fmt::format(
            "the contour file does not state its axes, and the model is in LPS: give the --frame that the "
            "model "
            "was made with{}",
            turned ? ", probably --frame RAS" : "");
    }
    if (broken(1) && contours) {
        const std::string distances = distance_text(contours->kept, model);
        if (!distances.empty())
            return distances +
                   ": check whether they are mirrored, scaled or shifted, are not the model's contours, or "
                   "need other "
                   "--close-slivers, --close-gaps or --same-line";
    }
    const double closed_mm = number_of(model.description, "close_gaps_mm").value_or(0);
    if ((broken(2) || broken(6)) && contours && closed_mm > widest_told_mm &&
        !walls_are_given(options.contours)) {
        return fmt::format(
            "the model's file states that gaps up to {0} mm were closed: to close them here too, give "
            "--close-gaps {0}",
            closed_mm);
    }
    if (broken(4) && !contours) {
        return "the certificate says which and where; give --contours to accept tetrahedra that contours "
               "force";
    }
    return "the certificate says which and where";
}

Result<ModelFile> model_to_check(const CheckOptions& options, Session& session) {
    ANATOMESH_TRY(MeshInput input, read_mesh(options.model, session.limits, session.context));
    if (input.model) return *std::move(input.model);
    return Error{ErrorKind::input,
                 "E-CMD-012",
                 "the file holds a surface, which has no tetrahedra to check",
                 {options.model, "", "", "", ""},
                 "give a model: .vtu, .msh, .mesh or .inp"};
}

// Walls as the model's file says that they were shared, but where the user says else.
WallOptions walls_of(const ModelFile& model, const InputOptions& options) {
    WallOptions walls = options.prepare.walls;
    const auto take = [&](const char* option, const char* note, double& width) {
        const std::vector<std::string>& given = options.cleaning_given;
        const std::optional<double> told = number_of(model.description, note);
        if (std::find(given.begin(), given.end(), option) != given.end() || !told) return;
        if (*told >= 0 && *told <= widest_told_mm) width = *told;
    };
    take("--same-line", "same_line_mm", walls.same_line_mm);
    take("--close-slivers", "close_slivers_mm", walls.close_slivers_mm);
    take("--close-gaps", "close_gaps_mm", walls.close_gaps_mm);
    walls.same_line_mm = std::min(walls.same_line_mm, 0.1);
    return walls;
}

// What of the contours the model was made of, as its file says, where the command does not and they have it:
// other structures, and other slices, have a part in how planes are found and slices made to agree.
Result<InputContours> contours_as_taken(OpenedInput opened, const InputOptions& given, const ModelFile& model,
                                        RunContext& context) {
    InputOptions told = given;
    if (opened.contours && told.prepare.choice.structures.empty()) {
        told.prepare.choice.structures = options_of(model.description, "structure");
        if (told.prepare.choice.structures == std::vector<std::string>{"all"})
            told.prepare.choice.structures.clear();
    }
    if (told.prepare.choice.without.empty())
        told.prepare.choice.without = options_of(model.description, "without");
    if (told.prepare.choice.structures == given.prepare.choice.structures &&
        told.prepare.choice.without == given.prepare.choice.without)
        return contours_of(std::move(opened), given, context);
    RunContext apart;
    apart.threads = context.threads;
    apart.cancel = context.cancel;
    Result<InputContours> taken = contours_of(opened, told, apart);
    // These contours are of another file, or what model --contours wrote.
    if (!taken.ok() && taken.error().kind == ErrorKind::usage)
        return contours_of(std::move(opened), given, context);
    for (Warning& warning : apart.warnings) context.warn(std::move(warning));
    return taken;
}

bool has_all(const ModelFile& model, const ContourSet& contours) {
    std::vector<Vec3> points = model.mesh.points;
    const auto before = [](Vec3 a, Vec3 b) { return lexicographic_less(a, b); };
    std::sort(points.begin(), points.end(), before);
    return std::all_of(contours.points.begin(), contours.points.end(),
                       [&](Vec3 p) { return std::binary_search(points.begin(), points.end(), p, before); });
}

// Contours that a model was made of lack points that crowd; those re-routed on its surface may have some.
Result<InputContours> contours_to_check(OpenedInput opened, const InputOptions& given, const ModelFile& model,
                                        RunContext& context) {
    RunContext usual, exact;
    for (RunContext* apart : {&usual, &exact}) {
        apart->threads = context.threads;
        apart->cancel = context.cancel;
    }
    Result<InputContours> taken = contours_as_taken(opened, given, model, usual);
    const bool crowds = std::any_of(usual.warnings.begin(), usual.warnings.end(),
                                    [](const Warning& warning) { return warning.code == "W-CON-032"; });
    if (taken.ok() && crowds) {
        InputOptions all = given;
        all.prepare.epsilon_mm = 0;
        Result<InputContours> whole = contours_as_taken(std::move(opened), all, model, exact);
        if (whole.ok() && has_all(model, whole.value().kept)) {
            for (Warning& warning : exact.warnings) context.warn(std::move(warning));
            return whole;
        }
    }
    for (Warning& warning : usual.warnings) context.warn(std::move(warning));
    return taken;
}

Status run_check(CheckOptions options, Session& session) {
    options.contours.limits = session.limits;
    if (options.contours.input.empty() &&
        (!options.contours.frame.empty() || options.contours.volume ||
         !options.contours.prepare.choice.structures.empty() ||
         !options.contours.prepare.choice.without.empty() || !options.contours.cleaning_given.empty())) {
        const std::string option = !options.contours.frame.empty()                       ? "--frame"
                                   : options.contours.volume                             ? "--volume"
                                   : !options.contours.prepare.choice.structures.empty() ? "--structure"
                                   : !options.contours.prepare.choice.without.empty()
                                       ? "--without"
                                       : options.contours.cleaning_given.front();
        return Error{ErrorKind::usage,
                     "E-CMD-008",
                     option + " does not apply without --contours",
                     {},
                     fmt::format("give --contours too, or leave out {}", option)};
    }
    ANATOMESH_TRY(const ModelFile model, model_to_check(options, session));
    std::optional<InputContours> contours;
    std::optional<ContourSet> on_surface;
    ModelReport report;
    if (!options.contours.input.empty()) {
        options.contours.prepare.until = PrepareUntil::chosen;
        ANATOMESH_TRY(OpenedInput opened, open_input(options.contours, session.context));
        // Traced contours share their walls already.
        const WallOptions walls = opened.contours ? walls_of(model, options.contours) : WallOptions{0, 0, 0};
        const bool share_first = opened.contours && walls_are_given(options.contours);
        ANATOMESH_TRY(contours,
                      contours_to_check(std::move(opened), options.contours, model, session.context));
        ANATOMESH_TRY(ContoursOfModel both,
                      contours_of_model(std::move(contours->kept), model, walls, share_first,
                                        options.contours.input, session.context));
        contours->kept = std::move(both.drawn);
        on_surface = std::move(both.on_surface);
        report.contours.routed = std::move(both.routed);
        report.crossing.movement = std::move(both.movement);
        report.provenance.inputs = contours->files;
    }
    CertificateInput input{model.mesh, model.description.regions, model.description.structures};
    input.contours = contours ? &contours->kept : nullptr;
    input.on_surface = on_surface ? &*on_surface : nullptr;
    input.made_by_this_run = false;
    FieldOfModel field;
    if (contours) {
        ANATOMESH_TRY(field, field_of_model(model, contours->kept, session.context));
        input.field = field.made.field.get();
        input.field_origin = field.made.origin;
        input.field_volumes_mm3 = field.volumes_mm3;
        input.field_note = field.note;
        report.conventions.end_caps = field.caps;
    }
    check_model(
        input,
        {size_of(model.description).value_or(0), &model.mid_nodes, options.contours.input, options.model},
        session.context, report);
    state_movement(report);
    report.provenance.version = ANATOMESH_VERSION;
    report.provenance.command = quoted_command(session.words);
    report.conventions.space = model.description.space;
    report.conventions.unit = model.description.unit;
    report.warnings = session.context.warnings;
    if (!options.contours.keep_patient_ids) hide_dicom_names(report, session.words, options.contours.series);

    const std::string text = options.model + "\n" + report_summary(report) + certificate_text(report);
    ANATOMESH_CHECK_STATUS(print_answer(session, session.json ? report_json(report) : printable(text)));
    if (!any_broken(report.certificate)) return Nothing{};
    const auto broken =
        std::count_if(report.certificate.begin(), report.certificate.end(),
                      [](const Clause& clause) { return clause.state == ClauseState::broken; });
    return Error{ErrorKind::geometry,
                 "E-CMD-013",
                 fmt::format("the model breaks {} of the certificate",
                             counted(static_cast<std::uint64_t>(broken), "clause")),
                 {options.model, "", "", "", ""},
                 advice(options, model, contours ? &*contours : nullptr, report)};
}

}  // namespace

Work declare_check(CLI::App& verb) {
    auto options = std::make_shared<CheckOptions>();
    verb.add_option("MODEL", options->model,
                    "Tetrahedral model: .vtu, .msh, .mesh or .inp, of this or another program.")
        ->type_name("FILE")
        ->required();
    add_text(verb, "--contours", options->contours.input, "FILE",
             "The contours that the model must follow: vertices, cross-sections and volume are compared.");
    add_choice(verb, "--frame", options->contours.frame, {"LPS", "RAS"},
               "Axes of the coordinates, for a contour file that does not state them.");
    add_optional_count(verb, "--volume", options->contours.volume, 0,
                       "The volume to read from an image that holds several, or the time frame of guide "
                       "points. The first one is 0.");
    add_texts(verb, "--structure", options->contours.prepare.choice.structures, "NAME",
              "Compare this structure, by name or number. Repeatable. Default: all structures of the model.");
    group_new_options(verb, option_group::input);
    add_without_option(verb, options->contours);
    add_cleaning_options(verb, options->contours);
    for (const char* name : {"--same-line", "--close-slivers", "--close-gaps"}) {
        CLI::Option* const option = verb.get_option(name);
        option->description(option->get_description() + " The model's file overrides it.");
    }
    return [options](Session& session) { return run_check(*options, session); };
}

}  // namespace anatomesh
