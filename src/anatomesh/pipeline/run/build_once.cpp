#include "anatomesh/pipeline/run/build_once.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "anatomesh/pipeline/model/model_warnings.h"
#include "anatomesh/pipeline/run/cut_mesh.h"
#include "anatomesh/pipeline/run/finish_model.h"
#include "anatomesh/pipeline/run/improve_run.h"
#include "anatomesh/pipeline/run/prepare_run.h"
#include "anatomesh/pipeline/run/stage_figures.h"

namespace anatomesh {

namespace {

// A finer size may keep a structure whole that is thinner than this. [sizes; > 1; M 2026-11, set not recorded]
constexpr double hardly_thicker = 1.3;
// Between dense planes a surface so far from the field's is one of bumps and pits.
// [sizes; > 0; M 2026-11 few contours on dense planes]
constexpr double most_deviation = 0.3;

// The values between the steps; those of later steps are empty.
struct RunState {
    const ContourSet& source;
    const RunConfig& config;
    FieldAndVolumes known;
    std::optional<PreparedRun> prepared = {};   // from "field" on
    std::optional<PointSample> sample = {};     // from "sample" on
    std::unique_ptr<GrowingMesh> growing = {};  // from "delaunay" on
    WorkingMesh working = {};                   // from "cut" on, until the model has its mesh
    CutStats cut = {};
    RoutedRun routed = {};
    std::uint64_t edited_cells = 0;  // made by improvement
    Model model = {};                // its report from the start, its mesh from "certificate" on
    TopologyFindings topology = {};  // of the model
    StageFigures figures = {};       // of the step under way

    double size_mm() const { return sample ? sample->stats.size_mm : 0; }

    ImproveInput improve_input() const { return {source, config.options, sample->stats, *growing}; }

    // The mesh as it is, from "cut" on.
    const TetMesh& mesh() const { return model.mesh.cells.empty() ? working.mesh : model.mesh; }
};

Status field_step(RunState& run, RunContext& context) {
    ANATOMESH_TRY(run.prepared, prepare_run(run.source, run.config, run.known, context));
    run.model.report.lengths.slice_spacing_mm = run.prepared->field->slice_spacing();
    return Nothing{};
}

Status sample_step(RunState& run, RunContext& context) {
    PreparedRun& prepared = *run.prepared;
    const ModelOptions& options = run.config.options;
    ANATOMESH_TRY(run.sample, sample_run(prepared, options.size_mm, context));
    if (run.sample->has_pole) prepared.effort = effort_at_pole(prepared.effort);
    run.figures = sample_figures(run.sample->stats);
    run.model.report.lengths.size_mm = run.size_mm();
    warn_of_thin_structures(prepared.contours, mean_thickness(prepared.contours), run.size_mm(), context);
    return check_cell_count(*run.sample, options.max_tetrahedra);
}

Status delaunay_step(RunState& run, RunContext& context) {
    ANATOMESH_TRY(Tetrahedralization delaunay,
                  Tetrahedralization::create(run.sample->points, context.threads));
    run.growing = std::make_unique<GrowingMesh>(std::move(delaunay), *run.prepared, *run.sample);
    return Nothing{};
}

Status cull_step(RunState& run, RunContext& context) {
    LabelledMesh& mesh = run.growing->mesh;
    const CullStats stats = mesh.update(context);
    ANATOMESH_CHECK_STATUS(check_region_count(mesh));
    run.model.report.meshing.share_culled =
        static_cast<double>(stats.culled) / static_cast<double>(mesh.regions().size());
    run.figures = cull_figures(mesh.regions().size(), stats);
    return Nothing{};
}

Status refine_step(RunState& run, RunContext& context) {
    const PreparedRun& prepared = *run.prepared;
    const Effort& effort = prepared.effort;
    GrowingMesh& growing = *run.growing;
    RefinementOptions options;
    options.size_mm = run.size_mm();
    options.max_radius_edge = run.config.options.max_radius_edge;
    options.crowded_mm = effort.refinement.crowded_sizes * run.size_mm();
    options.max_deviation_mm = effort.refinement.deviation_sizes * run.size_mm();
    options.spared = effort.reduced;
    options.conforming = effort.conforming;
    options.graded = run.sample->graded;
    options.target_mean_ratio = run.config.target_mean_ratio;
    if (effort.fits_sections)
        options.slices = {crossing_planes(prepared.slices), prepared.slices.weights, prepared.contradicted};
    growing.refinement.emplace(growing.mesh, growing.subsegments, run.sample->protected_segments,
                               growing.given, options);
    ANATOMESH_CHECK_STATUS(growing.refinement->run(context));
    const RefinementStats& stats = growing.refinement->stats();
    run.model.report.meshing.radius_edge_mean_before_refinement = stats.radius_edge_mean_before;
    run.figures = refine_figures(stats, growing.subsegments);
    return Nothing{};
}

Status cut_step(RunState& run, RunContext& context) {
    ANATOMESH_CHECK_STATUS(cut_mesh(*run.prepared, run.sample->stats, run.config.options.max_radius_edge,
                                    *run.growing, run.working, run.cut, context));
    run.figures = cut_figures(run.cut);
    return Nothing{};
}

Status improve_step(RunState& run, RunContext& context) {
    ANATOMESH_TRY(const ImprovedStats stats,
                  improve_run(*run.prepared, run.improve_input(), run.working, run.routed, context));
    run.edited_cells = stats.dihedrals.cells_made;
    run.figures = improve_figures(stats);
    return Nothing{};
}

Status certificate_step(RunState& run, RunContext& context) {
    finish_model(*run.prepared, run.improve_input(), run.working, run.routed, run.model, context.threads);
    measure_run(*run.prepared, run.source, context, run.model);
    return Nothing{};
}

struct RunStep {
    const char* stage;  // as progress, stage dumps and the report name it
    double share_done;  // of the run, after it
    Status (*run)(RunState& run, RunContext& context);
};

// The run, in order.
constexpr RunStep steps[] = {
    {"field", 0.05, field_step},    // what is drawn becomes a function of space; what is done is decided
    {"sample", 0.15, sample_step},  // points on contours, on the surface and of a lattice
    {"delaunay", 0.35, delaunay_step},
    {"cull", 0.45, cull_step},               // every cell gets a region
    {"refine", 0.6, refine_step},            // points where surface, slices or shapes need them
    {"cut", 0.75, cut_step},                 // surfaces become manifolds
    {"improve", 0.85, improve_step},         // shapes, sections, volumes
    {"certificate", 1.0, certificate_step},  // the model in the caller's coordinates, measured
};

StageReport stage_report(const RunState& run, const std::string& name, double seconds) {
    StageReport stage;
    stage.name = name;
    stage.seconds = seconds;
    const TetMesh& mesh = run.mesh();
    if (!mesh.cells.empty()) {
        stage.points = mesh.points.size();
        stage.cells = mesh.cells.size();
    } else if (run.growing) {
        stage.points = run.growing->mesh.points().size();
        stage.cells = run.growing->mesh.regions().size();
    } else if (run.sample) {
        stage.points = run.sample->points.size();
    }
    stage.figures = run.figures;
    return stage;
}

void show(const RunState& run, const std::string& name, const StageObserver& observer) {
    if (!run.model.mesh.cells.empty()) return observer(name, run.model.mesh);
    TetMesh mesh = run.working.mesh;
    const LabelledMesh& growing = run.growing->mesh;
    if (mesh.cells.empty()) mesh = {growing.points(), growing.cells().cells, growing.regions()};
    if (mesh.regions.empty()) return;
    move_back(run.prepared->origin, mesh.points);
    observer(name, mesh);
}

// Each step is noted in the report and shows its mesh; then the run stops if the user wants it.
Status run_steps(RunState& run, RunContext& context, const StageObserver& observer) {
    using Clock = std::chrono::steady_clock;
    auto start = Clock::now();
    for (const RunStep& step : steps) {
        ANATOMESH_CHECK_STATUS(step.run(run, context));
        const auto now = Clock::now();
        const std::chrono::duration<double> seconds = now - start;
        run.model.report.run.stages.push_back(stage_report(run, step.stage, seconds.count()));
        run.figures.clear();
        start = now;
        if (observer && run.growing) {
            show(run, step.stage, observer);
            start = Clock::now();
        }
        context.report(step.stage, step.share_done);
        if (context.cancelled()) return cancelled_error();
    }
    return Nothing{};
}

Result<Model> run_to_model(RunState& run, RunContext& context, const StageObserver& observer) {
    ANATOMESH_CHECK_STATUS(run_steps(run, context, observer));
    const Status judged = judge_run(*run.prepared, run.model.report, run.config.size_given);
    // What is looked at next goes over neighbours and indices, which a mesh that is unsound need not have.
    if (!judged.ok() && judged.error().kind == ErrorKind::internal) return judged.error();
    run.topology = warn_of_run(*run.prepared, run.model, run.working.neighbors, context);
    ANATOMESH_CHECK_STATUS(judged);
    return std::move(run.model);
}

// Whether the mesh tore a structure that a finer size may keep whole: one hardly thicker than the size, or
// one that goes on simply from end to end.
bool tore_a_structure(const RunState& run) {
    const std::vector<double> thickness = mean_thickness(run.prepared->contours);
    const std::vector<TopologyMismatch>& tears = run.topology.of_slices;
    return std::any_of(tears.begin(), tears.end(), [&](const TopologyMismatch& tear) {
        return tear.by_mesh && (tear.whole || thickness[tear.structure] < hardly_thicker * run.size_mm());
    });
}

std::size_t cells_so_far(const RunState& run) {
    if (!run.mesh().cells.empty()) return run.mesh().cells.size();
    return run.growing ? run.growing->mesh.regions().size() : 0;
}

RunOutcome outcome_of_run(const RunState& run, const Result<Model>& model) {
    const Effort effort = run.prepared ? run.prepared->effort : Effort{};
    const bool recovered = run.cut.recovered.missing_after < run.cut.recovered.missing_before;
    RunFacts facts;
    facts.size_mm = run.size_mm();
    facts.cells = model.ok() ? model.value().mesh.cells.size() : cells_so_far(run);
    // The same size may be tried with more work.
    facts.can_do_more = effort.reduced || recovered || (run.growing && run.growing->subsegments.are_short());
    facts.conformed = effort.conforming;
    facts.segments_missed = run.routed.segments_missed;
    facts.has_segments_beside = run.routed.has_segments_beside;
    facts.drawn_segments = run.source.points.size();
    // Or it was not looked at.
    const bool is_contradicted = run.prepared && !run.prepared->contradicted.empty();
    facts.contradicted = !effort.is_apart() && (!effort.fits_sections || is_contradicted);
    if (!model.ok()) return outcome_of(model, run.model.report, facts);
    const ModelReport& report = model.value().report;
    facts.torn = tore_a_structure(run);
    facts.spurious_joints = spurious_places(run.topology);
    facts.deviates = effort.conforming && effort.is_dense() &&
                     report.field.distance.max_mm > most_deviation * run.size_mm();
    return outcome_of(model, report, facts);
}

}  // namespace

BuiltOnce build_once(const ContourSet& contours, const RunConfig& config, RunContext& context,
                     const StageObserver& observer, FieldAndVolumes known) {
    RunState run{.source = contours, .config = config, .known = std::move(known)};
    Result<Model> model = run_to_model(run, context, observer);
    const RunOutcome outcome = outcome_of_run(run, model);
    const WorkReport work{1, run.growing ? run.growing->mesh.cells_made() : 0, run.edited_cells,
                          run.prepared && run.prepared->counted ? run.prepared->counted->values() : 0};
    FieldAndVolumes found = run.prepared ? std::move(run.prepared->known) : std::move(run.known);
    return {std::move(model), outcome, std::move(found), run.size_mm(), work};
}

}  // namespace anatomesh
