// anatomesh model: the main job, from an input to a checked tetrahedral model and its report.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/overlaps/outlines_between.h"
#include "anatomesh/pipeline/contours_in_planes.h"
#include "anatomesh/pipeline/make_model.h"
#include "anatomesh/pipeline/model/quadratic_model.h"
#include "anatomesh/uncertainty/left_out.h"
#include "anatomesh/uncertainty/surface_uncertainty.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/provenance/model_description.h"
#include "anatomesh_io/report/report_html.h"
#include "anatomesh_io/report/report_json.h"
#include "command_words.h"
#include "dicom_input.h"
#include "dicom_outputs.h"
#include "element_options.h"
#include "field_options.h"
#include "help_text.h"
#include "input_options.h"
#include "mesh_input.h"
#include "option_values.h"
#include "outputs.h"
#include "progress_bar.h"
#include "read_input.h"
#include "reconcile_options.h"
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
    double size_mm = MakeModelOptions{}.size_mm;
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

MakeModelOptions making_options(const ModelVerbOptions& options, const Session& session) {
    MakeModelOptions making;
    making.prepare = options.input.prepare;
    making.size_mm = options.size_mm;
    making.max_tetrahedra = session.limits.tetrahedra;
    making.max_memory_bytes = allowed_memory(session.limits);
    if (options.element.order == 2) making.report_options.emplace_back("order", "2");
    if (options.separate) making.report_options.emplace_back("separate", "yes");
    if (options.uncertainty) making.report_options.emplace_back("uncertainty", "yes");
    return making;
}

// What the library does not know: the command, and the files that were read.
void complete_report(ModelReport& report, const InputContours& contours, const StageReport& reading,
                     const Session& session) {
    report.provenance.command = quoted_command(session.words);
    report.provenance.inputs.insert(report.provenance.inputs.begin(), contours.files.begin(),
                                    contours.files.end());
    report.run.stages.insert(report.run.stages.begin(), reading);
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
Result<std::vector<PointArray>> uncertainty_arrays(const Model& model, const ModelVerbOptions& options,
                                                   RunContext& context) {
    const ContourSet drawn = drawn_alone(model.drawn);
    LeftOutOptions leaving;
    leaving.field = options.input.prepare.field;
    ANATOMESH_TRY(const LeftOut errors, leave_slices_out(drawn, leaving, context));
    SurfaceUncertainty found = surface_uncertainty(drawn, errors, model.mesh, model.regions, context);
    return std::vector<PointArray>{{"uncertainty", std::move(found.expected)},
                                   {"evidence_distance", std::move(found.evidence)},
                                   {"left_out_error", std::move(found.left_out)}};
}

// All outputs under temporary names.
Status stage_outputs(Model& model, ModelFile& file, const ModelVerbOptions& options, AtomicFileSet& files,
                     Session& session) {
    RunContext& context = session.context;
    std::vector<Material> materials = std::move(file.description.materials);
    file.description = description_of(model);
    file.description.materials = std::move(materials);
    if (options.uncertainty) {
        ANATOMESH_TRY(file.arrays, uncertainty_arrays(model, options, context));
    }
    ANATOMESH_TRY(const std::string mesh_bytes, format_model(options.output, file, context));
    ANATOMESH_CHECK_STATUS(files.add(options.output, mesh_bytes));
    if (!options.surfaces.empty()) {
        ANATOMESH_CHECK_STATUS(add_surfaces(file, options.surfaces, files, context));
    }
    if (!options.contours.empty()) {
        ANATOMESH_TRY(const ContourFormat format, contour_format_of(options.contours));
        const ContourSet contours = contours_in_planes(model, CleanOptions{}.planes.plane_tolerance_mm);
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
Result<ModelFile> file_of(Model& model, const ModelVerbOptions& options, std::span<const Structure> of_run,
                          std::string& materials, Session& session) {
    ModelFile file;
    file.mesh = model.mesh;
    if (options.element.order == 2) {
        ANATOMESH_TRY(file.mid_nodes, quadratic_model(model, model.contours, {}, session.context));
    }
    if (!options.element.wanted()) return file;
    file.description.structures = model.structures;
    file.description.regions = model.regions;
    ANATOMESH_TRY(CellValues values,
                  add_cell_values(file, options.element,
                                  options.input.prepare.label_maps.threshold ? &options.input : nullptr,
                                  session, of_run));
    materials = materials_text(values.materials);
    for (StageReport& stage : values.stages) model.report.run.stages.push_back(std::move(stage));
    for (InputReport& input : values.files) model.report.provenance.inputs.push_back(std::move(input));
    return file;
}

// What is said about the models that were made.
struct Answers {
    std::vector<std::string> json, text;
};

void add_answer(const Model& model, const ModelVerbOptions& options, const std::string& materials,
                const Session& session, Answers& answers) {
    if (session.json) return answers.json.push_back(report_json(model.report));
    answers.text.push_back(printable(options.output + "\n" + report_summary(model.report) + materials +
                                     certificate_line(model.report)));
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

// Makes one model and adds its outputs to `files`.
Status make_one(const PreparedContours& prepared, const InputContours& contours, const StageReport& reading,
                const ModelVerbOptions& options, AtomicFileSet& files, Answers& answers, Session& session) {
    RunContext& context = session.context;
    // A second attempt at the model shows its stages again: the last one counts.
    std::vector<ModelFile> dumps(options.dumps.size());
    const StageObserver observer = [&](const std::string& stage, const TetMesh& mesh) {
        for (std::size_t i = 0; i < dumps.size(); ++i) {
            if (options.dumps[i].stage == stage) dumps[i] = dump_file(mesh, stage);
        }
    };
    ANATOMESH_TRY(Model model, make_model(prepared, making_options(options, session), context,
                                          dumps.empty() ? StageObserver{} : observer));
    for (std::size_t i = 0; i < dumps.size(); ++i) {
        ANATOMESH_TRY(const std::string bytes, format_model(options.dumps[i].path, dumps[i], context));
        ANATOMESH_CHECK_STATUS(files.add(options.dumps[i].path, bytes));
    }
    std::string materials;
    ANATOMESH_TRY(ModelFile file, file_of(model, options, contours.kept.structures, materials, session));
    complete_report(model.report, contours, reading, session);
    ANATOMESH_CHECK_STATUS(stage_outputs(model, file, options, files, session));
    if (!options.dicom.paths().empty()) {
        ANATOMESH_TRY(const DicomSource source, output_source(options.input, contours.dicom_source, context));
        ANATOMESH_CHECK_STATUS(add_dicom_outputs(model, source, options.dicom, files, context));
    }
    add_answer(model, options, materials, session, answers);
    return Nothing{};
}

// One model of each structure. The files of each tell what was said of all the input, and of itself.
template <class Begin>
Status make_separate_models(const InputContours& contours, const StageReport& reading,
                            const ModelVerbOptions& options, AtomicFileSet& files, Answers& answers,
                            const Begin& begin, Session& session) {
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
        Status made =
            make_one(choose_structures(contours, {&s, 1}), contours, reading, part, files, answers, session);
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
                 "--separate makes several models, but a DICOM object holds one",
                 {},
                 "leave out --separate, or choose a structure with --structure"};
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
    const StageReport reading{"read", watch.lap(), 0, 0, {}};
    begin("contours", 0.08, 0.15);
    const auto check = [&](const ContourSet& kept) -> Status {
        ANATOMESH_CHECK_STATUS(
            check_slice_thickness(options.input.prepare.field.single_slice_mm, options.input.input, kept));
        ANATOMESH_CHECK_STATUS(check_materials(options.element, kept.structures,
                                               options.input.prepare.label_maps.threshold.has_value(),
                                               session.limits.input));
        return check_reconcile_options(kept, options.input);
    };
    ANATOMESH_TRY(const InputContours contours,
                  contours_of(std::move(opened), options.input, context, check));

    AtomicFileSet files;
    Answers answers;
    if (options.separate) {
        ANATOMESH_CHECK_STATUS(
            make_separate_models(contours, reading, options, files, answers, begin, session));
    } else {
        begin("model", 0.15, 1);
        ANATOMESH_CHECK_STATUS(make_one(contours, contours, reading, whole, files, answers, session));
    }
    context.progress = nullptr;
    bar.reset();
    return files.commit([&] { return answer(answers, options.separate, session); });
}

}  // namespace

Work declare_model(CLI::App& verb) {
    auto options = std::make_shared<ModelVerbOptions>();
    add_reading_options(verb, options->input);
    add_text(verb, "-o,--output", options->output, "MODEL",
             "The model to write: .vtu, .msh, .mesh, .inp or .feb.")
        ->required();
    group_new_options(verb, option_group::outputs);
    add_selection_options(verb, options->input);
    add_cleaning_options(verb, options->input);
    add_number(
        verb, "--size", options->size_mm, 0.01, 1000, "MM",
        "Edge length of the tetrahedra to aim at, 0.01 to 1000 mm. Default: chosen from the contours.");
    group_new_options(verb, option_group::mesh);
    add_field_rule_options(verb, options->input.prepare.field);
    add_reconcile_options(verb, options->input);
    add_element_options(verb, options->element);
    add_texts(
        verb, "--priority", options->input.prepare.priority, "NAME",
        "Where structures overlap, this one, by name or number, keeps the overlap. Repeatable; the first has "
        "the highest priority, then the smaller of two. Default: overlaps are regions of their own.");
    verb.add_flag(
        "--separate", options->separate,
        "Make one model of each structure by itself: MODEL-NUMBER.vtu, and so for all other outputs.");
    group_new_options(verb, option_group::mesh);
    add_texts(verb, "--surface", options->surfaces, "FILE",
              "Also write the surface: .vtp, .stl, .ply or .obj. Repeatable.");
    add_text(verb, "--contours", options->contours, "FILE",
             "Also write the contours that the model was made of: .json, .vtp or .csl.");
    add_text(verb, "--report", options->report, "FILE",
             "The report to write: .json. Default: the model's name with the ending .report.json.");
    add_text(verb, "--html", options->html, "FILE",
             "Also write the report as a page for a browser, with a view of the model: .html.");
    verb.add_flag("--uncertainty", options->uncertainty,
                  "Also estimate the error of the surface at every point in mm, as arrays in .vtu and .vtp.");
    add_dicom_output_options(verb, options->dicom);
    verb.add_option_function<std::vector<std::string>>(
            "--dump",
            [options](const std::vector<std::string>& texts) {
                for (const std::string& text : texts) options->dumps.push_back(dump_of(text));
            },
            fmt::format("Also write the mesh after a stage, for developers: {}. Repeatable.",
                        fmt::join(dump_stages, ", ")))
        ->type_name("STAGE=FILE")
        ->allow_extra_args(false);
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_model(*options, session); };
}

}  // namespace anatomesh
