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

#include "anatomesh/mesh/topology.h"
#include "anatomesh/pipeline/build_model.h"
#include "anatomesh/pipeline/quadratic_model.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/contour/write_contours.h"
#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/report/report_html.h"
#include "anatomesh_io/report/report_json.h"
#include "estimate.h"
#include "dicom_input.h"
#include "dicom_outputs.h"
#include "element_options.h"
#include "input_options.h"
#include "option_values.h"
#include "outputs.h"
#include "progress_bar.h"
#include "read_input.h"
#include "reconcile_step.h"
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
    double max_gap_spacings = FieldOptions{}.max_gap_spacings;
    double slice_thickness_mm = 0;  // 0: not stated
    ReconcileStepOptions reconcile;
    std::string caps = "half";
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
MeshDescription description_of(const Model& model, const Session& session) {
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
void complete_report(ModelReport& report, InputContours& contours, const ModelVerbOptions& options,
                     const Session& session) {
    report.version = ANATOMESH_VERSION;
    report.command = session.command;
    report.inputs.insert(report.inputs.begin(), contours.files.begin(), contours.files.end());
    report.contour_log = std::move(contours.log);
    report.hole_rule = contours.hole_rule;
    report.end_caps = options.caps;
    report.space = contours.kept.frame == Frame::unknown ? "unknown" : "LPS";
    report.traced_points = contours.traced_points;
    report.islands_left_out = contours.islands_left_out;
    report.epsilon_mm = contours.epsilon_mm;
    report.options = std::move(contours.options);
    std::string size;
    append_number(size, report.size_mm);
    report.options.emplace_back("size_mm", size);
    report.options.emplace_back("caps", options.caps);
    if (!report.crossing.pairs.empty()) {
        std::string bound;
        append_number(bound, options.reconcile.stage.max_disagreement_mm);
        report.options.emplace_back("max_disagreement_mm", bound);
        report.options.emplace_back("reconcile", options.reconcile.reconcile);
        report.options.emplace_back("align", options.reconcile.stage.align ? "yes" : "no");
    }
    if (options.element.order == 2) report.options.emplace_back("order", "2");
    std::string gap;
    append_number(gap, options.max_gap_spacings);
    report.options.emplace_back("max_gap_spacings", gap);
    if (options.slice_thickness_mm > 0) {
        std::string thickness;
        append_number(thickness, options.slice_thickness_mm);
        report.options.emplace_back("slice_thickness_mm", thickness);
    }
    report.warnings = session.context.warnings;
}

Status add_surfaces(const Model& model, const MeshDescription& description,
                    const std::vector<std::string>& paths, AtomicFileSet& files, RunContext& context) {
    const SurfaceFile surface{extract_interfaces(model.mesh), description};
    for (const std::string& path : paths) {
        ANATOMESH_TRY(const std::string bytes, format_surface(path, surface, context));
        ANATOMESH_CHECK_STATUS(files.add(path, bytes));
    }
    return Nothing{};
}

// All outputs under temporary names.
Status stage_outputs(Model& model, ModelFile& file, const ContourSet& kept, const ModelVerbOptions& options,
                     AtomicFileSet& files, Session& session) {
    RunContext& context = session.context;
    std::vector<Material> materials = std::move(file.description.materials);
    file.description = description_of(model, session);
    file.description.materials = std::move(materials);
    ANATOMESH_TRY(const std::string mesh_bytes, format_model(options.output, file, context));
    ANATOMESH_CHECK_STATUS(files.add(options.output, mesh_bytes));
    if (!options.surfaces.empty()) {
        ANATOMESH_CHECK_STATUS(add_surfaces(model, file.description, options.surfaces, files, context));
    }
    if (!options.contours.empty()) {
        ANATOMESH_TRY(const ContourFormat format, contour_format_of(options.contours));
        ANATOMESH_CHECK_STATUS(files.add(options.contours, format_contours(kept, format, context)));
    }
    model.report.warnings = context.warnings;  // with those of the formats
    ANATOMESH_CHECK_STATUS(files.add(options.report, report_json(model.report)));
    if (!options.html.empty()) {
        const std::string page = report_html(model.report, model.mesh, model.regions, &kept);
        ANATOMESH_CHECK_STATUS(files.add(options.html, page));
    }
    if (context.cancelled()) return cancelled_error();
    return Nothing{};
}

// What the file of the model has beside the mesh: mid-nodes, grey values, materials.
Result<ModelFile> model_file(Model& model, const InputContours& contours, const ModelVerbOptions& options,
                             Session& session) {
    ModelFile file;
    file.mesh = model.mesh;
    if (options.element.order == 2) {
        ANATOMESH_TRY(file.mid_nodes, quadratic_model(model, contours.kept, {}, session.context));
    }
    if (!options.element.wanted()) return file;
    file.description.structures = model.structures;
    file.description.regions = model.regions;
    ANATOMESH_TRY(CellValues values, add_cell_values(file, options.element,
                                                     options.input.threshold ? &options.input : nullptr, session));
    for (StageReport& stage : values.stages) model.report.stages.push_back(std::move(stage));
    for (InputReport& input : values.files) model.report.inputs.push_back(std::move(input));
    return file;
}

Status answer(const Model& model, const ModelVerbOptions& options, Session& session) {
    if (session.json) return print_answer(session, report_json(model.report));
    if (session.quiet || session.output_closed) return Nothing{};
    return print_answer(session, printable(options.output + "\n" + report_summary(model.report) +
                                           certificate_line(model.report)));
}

Status run_model(ModelVerbOptions options, Session& session) {
    options.input.limits = session.limits;
    if (options.report.empty()) options.report = with_ending(options.output, ".report.json");
    ANATOMESH_CHECK_STATUS(check_output_names(options));

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
    ANATOMESH_CHECK_STATUS(check_outputs(names_of(opened.files), outputs_of(options)));
    StageReport reading{"read", watch.lap(), 0, 0, {}};
    begin("contours", 0.08, 0.15);
    ANATOMESH_TRY(InputContours contours, contours_of(std::move(opened), options.input, context));
    StageReport tracing{"contours", watch.lap(), contours.kept.points.size(), 0, {}};

    ANATOMESH_TRY(CrossingReport crossing, reconcile_step(contours.kept, options.reconcile, context));
    StageReport reconciling{"reconcile", watch.lap(), contours.kept.points.size(), 0, {}};

    // A second attempt at the model shows its stages again: the last one counts.
    std::vector<ModelFile> dumps(options.dumps.size());
    const StageObserver observer = [&](const std::string& stage, const TetMesh& mesh) {
        for (std::size_t i = 0; i < dumps.size(); ++i) {
            if (options.dumps[i].stage == stage) dumps[i] = dump_file(mesh, stage);
        }
    };
    begin("model", 0.15, 0.9);
    ModelOptions building;
    building.size_mm = options.size_mm;
    building.max_gap_spacings = options.max_gap_spacings;
    building.single_slice_mm = options.slice_thickness_mm;
    building.max_tetrahedra = session.limits.tetrahedra;
    if (options.size_mm > 0) {
        ANATOMESH_CHECK_STATUS(check_size(contours.kept, options.size_mm, session.limits));
    }
    building.caps = options.caps == "flat" ? EndCaps::flat : EndCaps::half;
    ANATOMESH_TRY(Model model, build_model(contours.kept, building, context, observer));
    AtomicFileSet files;
    for (std::size_t i = 0; i < dumps.size(); ++i) {
        ANATOMESH_TRY(const std::string bytes, format_model(options.dumps[i].path, dumps[i], context));
        ANATOMESH_CHECK_STATUS(files.add(options.dumps[i].path, bytes));
    }
    model.report.stages.insert(model.report.stages.begin(), {std::move(reading), std::move(tracing), std::move(reconciling)});
    model.report.crossing = std::move(crossing);
    ANATOMESH_TRY(ModelFile file, model_file(model, contours, options, session));
    complete_report(model.report, contours, options, session);
    begin("writing", 0.9, 1);
    ANATOMESH_CHECK_STATUS(stage_outputs(model, file, contours.kept, options, files, session));
    if (!options.dicom.paths().empty()) {
        ANATOMESH_TRY(const DicomSource source, output_source(options.input, contours.dicom_source, context));
        ANATOMESH_CHECK_STATUS(add_dicom_outputs(model, source, options.dicom, files, context));
    }
    context.progress = nullptr;
    bar.reset();
    return files.commit([&] { return answer(model, options, session); });
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
    add_choice(verb, "--caps", options->caps, {"half", "flat"},
               "Where a structure ends beyond its last contour: half a slice further (default), or at it");
    add_number(
        verb, "--max-gap", options->max_gap_spacings, 1, 1e6, "SPACINGS",
        "Join contours of a structure over a gap of up to so many slice spacings, 1 to 1000000 (default 2)");
    add_number(verb, "--slice-thickness", options->slice_thickness_mm, 0.001, 1000, "MM",
               "How thick a slice is when there is only one, 0.001 to 1000");
    add_reconcile_options(verb, options->reconcile);
    add_element_options(verb, options->element);
    add_texts(verb, "--surface", options->surfaces, "FILE",
              "Also write the surface: .vtp, .stl, .ply or .obj; may be repeated");
    add_text(verb, "--contours", options->contours, "FILE",
             "Also write the contours used: .json, .vtp or .csl");
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
