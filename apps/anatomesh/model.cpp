// anatomesh model: the main job, from an input to a checked tetrahedral model and its report.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/choose_structures.h"
#include "anatomesh/overlaps/outlines_between.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/model/quadratic_model.h"
#include "anatomesh/uncertainty/left_out.h"
#include "anatomesh/uncertainty/surface_uncertainty.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/report/report_html.h"
#include "anatomesh_io/report/report_json.h"
#include "command_words.h"
#include "dicom_input.h"
#include "dicom_outputs.h"
#include "element_options.h"
#include "estimate.h"
#include "field_options.h"
#include "followed_notes.h"
#include "input_options.h"
#include "mesh_input.h"
#include "option_values.h"
#include "outputs.h"
#include "progress_bar.h"
#include "read_input.h"
#include "reconcile_step.h"
#include "report_names.h"
#include "summary.h"
#include "verbs.h"

namespace anatomesh {

namespace {

// Seconds since it was made, or since the last lap.
class Stopwatch {
  public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct DumpOption {
    std::string stage, path;
};

struct ModelVerbOptions {
    InputOptions input;
    double size_mm = 0;
    FieldRuleOptions rules;
    ReconcileStepOptions reconcile;
    std::vector<std::string> priority;
    bool separate = false, uncertainty = false;
    std::string output, report, html, contours;
    std::vector<std::string> surfaces;
    std::vector<DumpOption> dumps;
    DicomOutputs dicom;
    ElementOptions element;
};

// The stages whose mesh can be dumped, in the order of the pipeline.
const std::vector<std::string> dump_stages{"cull", "refine", "cut", "improve", "certificate"};

DumpOption dump_of(const std::string& text) {
    const std::size_t equals = text.find('=');
    const std::string stage = text.substr(0, equals);
    if (equals == std::string::npos || equals + 1 == text.size() ||
        std::find(dump_stages.begin(), dump_stages.end(), stage) == dump_stages.end()) {
        throw CLI::ValidationError("--dump", fmt::format("'{}' is not STAGE=FILE with one of the stages {}",
                                                         text, fmt::join(dump_stages, ", ")));
    }
    return {stage, text.substr(equals + 1)};
}

std::vector<std::string> outputs_of(const ModelVerbOptions& options) {
    std::vector<std::string> outputs{options.output, options.report};
    outputs.insert(outputs.end(), options.surfaces.begin(), options.surfaces.end());
    if (!options.contours.empty()) outputs.push_back(options.contours);
    if (!options.html.empty()) outputs.push_back(options.html);
    for (const DumpOption& dump : options.dumps) outputs.push_back(dump.path);
    for (const std::string& path : options.dicom.paths()) outputs.push_back(path);
    return outputs;
}

Status check_output_names(const ModelVerbOptions& options) {
    ANATOMESH_CHECK_STATUS(check_dicom_outputs(options.dicom));
    ANATOMESH_CHECK_STATUS(check_mesh_output(options.output, false));
    ANATOMESH_CHECK_STATUS(check_order(options.element, options.output));
    for (const std::string& surface : options.surfaces) {
        ANATOMESH_CHECK_STATUS(check_surface_output(surface));
    }
    for (const DumpOption& dump : options.dumps) {
        ANATOMESH_CHECK_STATUS(check_mesh_output(dump.path, false));
    }
    if (!options.contours.empty()) {
        ANATOMESH_CHECK_STATUS(check_contour_output(options.contours));
    }
    ANATOMESH_CHECK_STATUS(check_extension(options.report, {".json"}));
    if (!options.html.empty()) {
        ANATOMESH_CHECK_STATUS(check_extension(options.html, {".html", ".htm"}));
    }
    std::vector<std::string> inputs = options.element.inputs();
    inputs.push_back(options.input.input);
    return check_outputs(inputs, outputs_of(options));
}

// Provenance, as it stands in every file of the mesh: nothing that differs between two runs on the same
// contours. The rest (command, input files and their hashes, every warning in full) stands in the report.
MeshDescription description_of(const Model& model, const ContourSet& kept, const Session& session) {
    const ModelReport& report = model.report;
    MeshDescription description;
    description.structures = model.structures;
    description.regions = model.regions;
    description.space = report.space;
    description.notes.emplace_back("version", report.version);
    for (const auto& [name, value] : report.options)
        description.notes.emplace_back("option", name + " " + value);
    std::map<std::string, int> warnings;
    for (const Warning& warning : session.context.warnings) ++warnings[warning.code];
    for (const auto& [code, times] : warnings) {
        description.notes.emplace_back("warning", fmt::format("{} {}", code, times));
    }
    add_followed_notes(model, kept, description);
    return description;
}

// A mesh between two stages: a structure per region, so that any viewer colours them.
ModelFile dump_file(const TetMesh& mesh, const std::string& stage) {
    ModelFile file;
    file.mesh = mesh;
    file.description.notes.emplace_back("stage", stage);
    Region last = 0;
    for (const Region region : mesh.regions) last = std::max(last, region);
    for (Region region = 1; region <= last; ++region) {
        file.description.structures.push_back({region, fmt::format("region {}", region), {200, 200, 200}});
        file.description.regions.members.push_back({region - 1u});
    }
    return file;
}

// What the caller of the pipeline knows and the pipeline does not.
void complete_report(ModelReport& report, const InputContours& contours, const ModelVerbOptions& options,
                     const Session& session) {
    report.version = ANATOMESH_VERSION;
    report.command = quoted_command(session.words);
    report.inputs.insert(report.inputs.begin(), contours.files.begin(), contours.files.end());
    report.contour_log = contours.log;
    report.hole_rule = contours.hole_rule;
    report.end_caps = options.rules.caps;
    report.space = contours.kept.frame == Frame::unknown ? "unknown" : "LPS";
    report.traced_points = contours.traced_points;
    report.islands_left_out = contours.islands_left_out;
    report.epsilon_mm = contours.epsilon_mm;
    report.options = contours.options;
    std::string size;
    append_number(size, report.size_mm);
    report.options.emplace_back("size_mm", size);
    report.options.emplace_back("caps", options.rules.caps);
    if (!report.crossing.pairs.empty()) {
        std::string bound;
        append_number(bound, options.reconcile.stage.max_disagreement_mm);
        report.options.emplace_back("max_disagreement_mm", bound);
        report.options.emplace_back("reconcile", options.reconcile.reconcile);
        report.options.emplace_back("align", options.reconcile.stage.align ? "yes" : "no");
    }
    if (options.element.order == 2) report.options.emplace_back("order", "2");
    if (options.separate) report.options.emplace_back("separate", "yes");
    if (options.uncertainty) report.options.emplace_back("uncertainty", "yes");
    std::string gap;
    append_number(gap, options.rules.max_gap_spacings);
    report.options.emplace_back("max_gap_spacings", gap);
    if (options.rules.slice_thickness_mm > 0) {
        std::string thickness;
        append_number(thickness, options.rules.slice_thickness_mm);
        report.options.emplace_back("slice_thickness_mm", thickness);
    }
    report.warnings = session.context.warnings;
}

Status add_surfaces(const ModelFile& file, const std::vector<std::string>& paths, AtomicFileSet& files,
                    RunContext& context) {
    const SurfaceFile surface = surface_of(file);
    for (const std::string& path : paths) {
        ANATOMESH_TRY(const std::string bytes, format_surface(path, surface, context));
        ANATOMESH_CHECK_STATUS(files.add(path, bytes));
    }
    return Nothing{};
}

// How sure the surface is, at every point of the mesh.
Result<std::vector<PointArray>> uncertainty_arrays(const Model& model, const ContourSet& kept,
                                                   const ModelVerbOptions& options, RunContext& context) {
    LeftOutOptions leaving;
    leaving.field = options.rules.field();
    ANATOMESH_TRY(const LeftOut errors, leave_slices_out(kept, leaving, context));
    SurfaceUncertainty found = surface_uncertainty(kept, errors, model.mesh, model.regions, context);
    return std::vector<PointArray>{{"uncertainty", std::move(found.expected)},
                                   {"evidence_distance", std::move(found.evidence)},
                                   {"left_out_error", std::move(found.left_out)}};
}

// All outputs under temporary names. `kept`: the contours that the model was made of.
Status stage_outputs(Model& model, ModelFile& file, const ContourSet& kept, const ModelVerbOptions& options,
                     AtomicFileSet& files, Session& session) {
    RunContext& context = session.context;
    std::vector<Material> materials = std::move(file.description.materials);
    file.description = description_of(model, kept, session);
    file.description.materials = std::move(materials);
    if (options.uncertainty) {
        ANATOMESH_TRY(file.arrays, uncertainty_arrays(model, drawn_alone(kept), options, context));
    }
    ANATOMESH_TRY(const std::string mesh_bytes, format_model(options.output, file, context));
    ANATOMESH_CHECK_STATUS(files.add(options.output, mesh_bytes));
    if (!options.surfaces.empty()) {
        ANATOMESH_CHECK_STATUS(add_surfaces(file, options.surfaces, files, context));
    }
    if (!options.contours.empty()) {
        ANATOMESH_TRY(const ContourFormat format, contour_format_of(options.contours));
        const ContourSet contours = contours_in_planes(model, kept, CleanOptions{}.plane_tolerance_mm);
        ANATOMESH_CHECK_STATUS(files.add(options.contours, format_contours(contours, format, context)));
    }
    model.report.warnings = context.warnings;  // with those of the formats
    if (!options.input.keep_patient_ids) hide_dicom_names(model.report, session.words, options.input.series);
    ANATOMESH_CHECK_STATUS(files.add(options.report, report_json(model.report)));
    if (!options.html.empty()) {
        const std::string page = report_html(model.report, model.mesh, model.regions, &model.contours);
        ANATOMESH_CHECK_STATUS(files.add(options.html, page));
    }
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

// What the file of the model has beside the mesh: mid-nodes, grey values, materials.
Result<ModelFile> model_file(Model& model, const ContourSet& kept, const ModelVerbOptions& options,
                             Session& session) {
    ModelFile file;
    file.mesh = model.mesh;
    if (options.element.order == 2) {
        ANATOMESH_TRY(file.mid_nodes, quadratic_model(model, kept, {}, session.context));
    }
    if (!options.element.wanted()) return file;
    file.description.structures = model.structures;
    file.description.regions = model.regions;
    ANATOMESH_TRY(
        CellValues values,
        add_cell_values(file, options.element, options.input.threshold ? &options.input : nullptr, session));
    for (StageReport& stage : values.stages) model.report.stages.push_back(std::move(stage));
    for (InputReport& input : values.files) model.report.inputs.push_back(std::move(input));
    return file;
}

// What is said about the models that were made.
struct Answers {
    std::vector<std::string> json, text;
};

void add_answer(const Model& model, const ModelVerbOptions& options, const Session& session,
                Answers& answers) {
    if (session.json) return answers.json.push_back(report_json(model.report));
    answers.text.push_back(
        printable(options.output + "\n" + report_summary(model.report) + certificate_line(model.report)));
}

Status answer(const Answers& answers, bool separate, Session& session) {
    if (session.json) {
        if (!separate) return print_answer(session, answers.json.front());
        return print_answer(session, fmt::format("{{\"models\": [{}]}}\n", fmt::join(answers.json, ",")));
    }
    if (session.quiet || session.output_closed) return Nothing{};
    return print_answer(session, fmt::format("{}", fmt::join(answers.text, "\n")));
}

// Where the output of one structure goes: organs.vtu, 5 -> organs-5.vtu.
std::string with_number(const std::string& path, std::int32_t number) {
    if (path.empty()) return path;
    const std::string stem = with_ending(path, "");
    return fmt::format("{}-{}{}", stem, number, path.substr(stem.size()));
}

ModelVerbOptions options_of_one(ModelVerbOptions options, std::int32_t number) {
    for (std::string* path : {&options.output, &options.report, &options.html, &options.contours})
        *path = with_number(*path, number);
    for (std::string& surface : options.surfaces) surface = with_number(surface, number);
    for (DumpOption& dump : options.dumps) dump.path = with_number(dump.path, number);
    if (options.report.empty()) options.report = with_ending(options.output, ".report.json");
    return options;
}

Status give_to_first(InputContours& contours, const ModelVerbOptions& options, RunContext& context) {
    if (options.priority.empty()) return Nothing{};
    ANATOMESH_TRY(const std::vector<std::uint32_t> order,
                  find_in_order(contours.kept.structures, options.priority, options.input.input));
    ANATOMESH_TRY(PriorityResult result,
                  part_structures(contours.kept, order, options.rules.field(), context));
    for (const std::uint32_t s : result.order)
        contours.options.emplace_back("priority", unique_text(contours.kept.structures, s));
    if (std::all_of(result.given.begin(), result.given.end(),
                    [](const auto& given) { return given.slices == 0; }))
        context.warn({"W-CMD-007",
                      "--priority was given, and no structures overlap on any slice",
                      {options.input.input, "", "", "", ""},
                      "no contour was changed; between the slices the structures exclude each other"});
    for (std::size_t s = 0; s < result.given.size(); ++s) {
        if (result.given[s].slices == 0 || result.given[s].all) continue;
        context.warn(
            {"W-CMD-006",
             "the structure overlaps others, which keep what they have in common",
             {options.input.input, "", contours.kept.structures[s].name, "",
              fmt::format("{:.4g} mm2 on {} slices", result.given[s].area_mm2, result.given[s].slices)},
             "taken from it; --priority names what comes first, and of the others the smaller one does"});
    }
    contours.kept = std::move(result.kept);
    if (contours.kept.overlapping) contours.options.emplace_back("overlaps", "nested");
    if (has_interpolated(contours.kept)) contours.options.emplace_back("outlines_between", "interpolated");
    return Nothing{};
}

// Builds one model and adds its outputs to `files`.
Status make_model(const ContourSet& kept, const InputContours& contours, const CrossingReport& crossing,
                  const std::vector<StageReport>& stages, const ModelVerbOptions& options,
                  AtomicFileSet& files, Answers& answers, Session& session) {
    RunContext& context = session.context;
    // A second attempt at the model shows its stages again: the last one counts.
    std::vector<ModelFile> dumps(options.dumps.size());
    const StageObserver observer = [&](const std::string& stage, const TetMesh& mesh) {
        for (std::size_t i = 0; i < dumps.size(); ++i) {
            if (options.dumps[i].stage == stage) dumps[i] = dump_file(mesh, stage);
        }
    };
    const FieldOptions field = options.rules.field();
    ModelOptions building;
    building.size_mm = options.size_mm;
    building.caps = field.caps;
    building.max_gap_spacings = field.max_gap_spacings;
    building.single_slice_mm = field.single_slice_mm;
    building.max_tetrahedra = session.limits.tetrahedra;
    if (options.reconcile.reconcile == "1")
        building.max_follow_mm = options.reconcile.stage.max_disagreement_mm;
    if (options.size_mm > 0) {
        ANATOMESH_CHECK_STATUS(check_size(kept, options.size_mm, session.limits));
    } else {
        ANATOMESH_CHECK_STATUS(check_default_size(kept));
    }
    ANATOMESH_TRY(Model model,
                  build_model(kept, building, context, dumps.empty() ? StageObserver{} : observer));
    for (std::size_t i = 0; i < dumps.size(); ++i) {
        ANATOMESH_TRY(const std::string bytes, format_model(options.dumps[i].path, dumps[i], context));
        ANATOMESH_CHECK_STATUS(files.add(options.dumps[i].path, bytes));
    }
    model.report.stages.insert(model.report.stages.begin(), stages.begin(), stages.end());
    model.report.crossing = crossing;
    ANATOMESH_TRY(ModelFile file, model_file(model, model.contours, options, session));
    complete_report(model.report, contours, options, session);
    ANATOMESH_CHECK_STATUS(stage_outputs(model, file, kept, options, files, session));
    if (!options.dicom.paths().empty()) {
        ANATOMESH_TRY(const DicomSource source, output_source(options.input, contours.dicom_source, context));
        ANATOMESH_CHECK_STATUS(add_dicom_outputs(model, source, options.dicom, files, context));
    }
    add_answer(model, options, session, answers);
    return Nothing{};
}

// One model of each structure. The files of each tell what was said of all the input, and of itself.
template <class Begin>
Status make_separate_models(const InputContours& contours, const CrossingReport& crossing,
                            const std::vector<StageReport>& stages, const ModelVerbOptions& options,
                            AtomicFileSet& files, Answers& answers, const Begin& begin, Session& session) {
    std::vector<Warning>& warnings = session.context.warnings;
    const auto of_all = static_cast<std::ptrdiff_t>(warnings.size());
    std::vector<Warning> said = warnings;
    const std::size_t count = contours.kept.structures.size();
    const double share = 0.85 / static_cast<double>(count);
    for (const Structure& structure : contours.kept.structures) {
        const ModelVerbOptions part = options_of_one(options, structure.number);
        ANATOMESH_CHECK_STATUS(check_outputs(names_of(contours.files), outputs_of(part)));
    }
    for (std::uint32_t s = 0; s < count; ++s) {
        begin("model", 0.15 + share * s, 0.15 + share * (s + 1));
        const ModelVerbOptions part = options_of_one(options, contours.kept.structures[s].number);
        warnings.erase(warnings.begin() + of_all, warnings.end());
        Status made = make_model(choose_structures(contours.kept, {&s, 1}), contours, crossing, stages, part,
                                 files, answers, session);
        said.insert(said.end(), warnings.begin() + of_all, warnings.end());
        if (!made.ok()) {
            warnings = std::move(said);
            return made;
        }
    }
    warnings = std::move(said);
    return Nothing{};
}

Status check_separate(const ModelVerbOptions& options) {
    if (!options.separate || options.dicom.paths().empty()) return Nothing{};
    return Error{ErrorKind::usage,
                 "E-CMD-008",
                 "--separate makes several models, and a DICOM object is of one",
                 {},
                 "leave out --separate, or choose a structure with --structure"};
}

Status check_slice_thickness(const ModelVerbOptions& options, const ContourSet& kept) {
    if (options.rules.slice_thickness_mm == 0 || kept.slices.size() < 2) return Nothing{};
    return Error{ErrorKind::usage,
                 "E-CMD-008",
                 fmt::format("--slice-thickness does not apply: there are {} slices", kept.slices.size()),
                 {options.input.input, "", "", "", ""},
                 "leave out --slice-thickness"};
}

Status run_model(ModelVerbOptions options, Session& session) {
    options.input.limits = session.limits;
    ModelVerbOptions whole = options;
    if (whole.report.empty()) whole.report = with_ending(whole.output, ".report.json");
    ANATOMESH_CHECK_STATUS(check_separate(options));
    ANATOMESH_CHECK_STATUS(check_output_names(whole));

    RunContext& context = session.context;
    std::optional<ProgressBar> bar;
    // Shares of the time as measured on the CT skull.
    const auto begin = [&](const char* part, double from, double to) {
        if (bar) bar->begin(part, from, to);
    };
    if (!session.quiet) {
        bar.emplace();
        context.progress = [&bar](const std::string&, double share) { bar->update(share); };
    }
    Stopwatch watch;
    begin("reading", 0, 0.08);
    ANATOMESH_TRY(OpenedInput opened, open_input(options.input, context));
    ANATOMESH_CHECK_STATUS(check_outputs(names_of(opened.files), outputs_of(whole)));
    StageReport reading{"read", watch.lap(), 0, 0, {}};
    begin("contours", 0.08, 0.15);
    ANATOMESH_TRY(InputContours contours, contours_of(std::move(opened), options.input, context));
    StageReport tracing{"contours", watch.lap(), contours.kept.points.size(), 0, {}};

    ANATOMESH_CHECK_STATUS(check_slice_thickness(options, contours.kept));
    ANATOMESH_TRY(const CrossingReport crossing,
                  reconcile_step(contours.kept, options.input.walls, options.reconcile, context));
    ANATOMESH_CHECK_STATUS(give_to_first(contours, options, context));
    const std::vector<StageReport> stages{
        reading, tracing, StageReport{"reconcile", watch.lap(), contours.kept.points.size(), 0, {}}};

    AtomicFileSet files;
    Answers answers;
    if (options.separate) {
        ANATOMESH_CHECK_STATUS(
            make_separate_models(contours, crossing, stages, options, files, answers, begin, session));
    } else {
        begin("model", 0.15, 1);
        ANATOMESH_CHECK_STATUS(
            make_model(contours.kept, contours, crossing, stages, whole, files, answers, session));
    }
    context.progress = nullptr;
    bar.reset();
    return files.commit([&] { return answer(answers, options.separate, session); });
}

}  // namespace

Work declare_model(CLI::App& verb) {
    auto options = std::make_shared<ModelVerbOptions>();
    add_reading_options(verb, options->input);
    add_text(verb, "-o,--output", options->output, "MODEL", "Model to write: .vtu, .msh, .mesh, .inp or .feb")
        ->required();
    add_selection_options(verb, options->input);
    add_cleaning_options(verb, options->input);
    add_number(verb, "--size", options->size_mm, 0.01, 1000, "MM",
               "Target edge length, 0.01 to 1000 (default: found from the data)");
    add_field_rule_options(verb, options->rules);
    add_reconcile_options(verb, options->reconcile);
    add_element_options(verb, options->element);
    add_texts(verb, "--priority", options->priority, "NAME",
              "Where structures overlap, NAME (or number) keeps what they have in common; may be repeated, "
              "the first wins; of those not named the smaller one");
    verb.add_flag(
        "--separate", options->separate,
        "Make one model of each structure by itself: MODEL-NUMBER.vtu, and so for every other output");
    verb.add_flag("--uncertainty", options->uncertainty,
                  "Also find how sure the surface is at every point, in mm: arrays of .vtu and .vtp");
    add_texts(verb, "--surface", options->surfaces, "FILE",
              "Also write the surface: .vtp, .stl, .ply or .obj; may be repeated");
    add_text(verb, "--contours", options->contours, "FILE",
             "Also write the contours used, as the surface has them in their planes: .json, .vtp or .csl");
    add_text(verb, "--report", options->report, "FILE",
             "Where the report goes: .json (default: the model's name with .report.json)");
    add_text(verb, "--html", options->html, "FILE",
             "Also write the report as one page with a view of the model: .html");
    add_dicom_output_options(verb, options->dicom);
    verb.add_option_function<std::vector<std::string>>(
            "--dump",
            [options](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) options->dumps.push_back(dump_of(text));
            },
            fmt::format("Also write the mesh after a stage ({}); may be repeated",
                        fmt::join(dump_stages, ", ")))
        ->type_name("STAGE=FILE")
        ->allow_extra_args(false);
    return [options](Session& session) { return run_model(*options, session); };
}

}  // namespace anatomesh
