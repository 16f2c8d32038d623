#include "anatomesh/pipeline/run/effort.h"

#include <algorithm>
#include <array>

#include "anatomesh/improve/reroute/snap_round_segments.h"
#include "anatomesh/sample/sample_points.h"

namespace anatomesh {

namespace {

// Planes are dense above this plane_density(), which has the 1.5 in it. [1; > 0; D]
constexpr double dense_above = 1;
// Above this plane_density() all that can be done is too much. [1; > dense_above; M 2026-11 dense freehand planes]
constexpr double crammed_above = 3;
// About an axis all is done for so many vertices of contours. [1; > 0; M 2026-11 dense planes]
constexpr std::size_t few_points = 5000;
// Where freehand planes lie closer than the vertices along them, contours show the surface without more
// points: the edge length grows by this with the depth. [mm per mm; 0 to 2; M 2026-11 dense freehand planes]
constexpr double reduced_growth = 2;
// Contour vertices nearer to each other than this times the density may spoil cells.
// [sizes; 0 to 1; M 2026-11 dense freehand planes]
constexpr double crowded_share = 0.08;
// The distance of vertices that may spoil cells is at most this.
// [sizes; 0 to 1; M 2026-11 dense freehand planes]
constexpr double most_crowded_share = 0.25;
// About an axis a run at reduced effort brings no subsegments onto the surface if a larger share is off it.
// [1; 0 to 1; M 2026-11, set not recorded]
constexpr double most_off_surface_at_pole = 0.003;
// Where planes cross, vertices less deep than this speak against no move (RelabelOptions::near_mm).
// [sizes; 0 to 1; M 2026-11 69 sets about an axis]
constexpr double near_share = 0.03;
// Where planes cross, a vertex within this share of its shortest edge lies on an interface.
// [1; 0 to 1; M 2026-11 planes about an axis]
constexpr double tolerance_of_crossing = 0.2;
// Between dense planes contours leave few vertices of the surface free: more points between them are needed
// to make the volume right. [sizes; > 0; M 2026-11 dense freehand planes]
constexpr double dense_deviation = 0.03;
// Of the cells inside, such a share may come above the bound for subsegments' sake at the first runs, and
// cells of no worse shape (cavity.h) are made; after more that were ill-shaped none.
// [1; 0 to 1; M 2026-11 fetal brain, random crossing stacks and sets about an axis]
constexpr std::array<RecoveryEffort, runs_without_recovery> recovery_by_failures{
    {{0.003, 0.01}, {0.001, 0.2}, {0.001, 0.4}}};
// Where planes cross, recovery makes no cells of a worse shape, which are not single there.
// [1; 0 to 1; M 2026-11 69 sets about an axis]
constexpr double least_shape_across = 0.1;
// For so many subsegments recovery leaves no shape untried: about an axis, and elsewhere at the first run.
// [subsegments; >= 0; M 2026-11 bone of a skull above 700 HU]
constexpr std::size_t few_subsegments = 10;
// Slices of a label map, far apart against its voxels, lack more subsegments where structures meet: the last
// few are fewer than one in so many. [1; >= 1; M 2026-11 CT labels, all and every third slice]
constexpr std::size_t last_few_of_labels = 40;
// A contour segment leaves its place by no more, along the surface.
// [sizes; 0 to 1; M 2026-11 282 random sets of planes that cross or lean]
constexpr double most_rerouted = 0.5;
// Where no planes cross it leaves its place by no more, so that none comes too near to another one.
// [sizes; 0 to 1; M 2026-11 skull mask]
constexpr double most_rerouted_parallel = 0.1;

// Where no planes cross, spikes and pits so high or deep are removed. Where planes cross, removing small ones made a section
// wrong. [sizes; > 0; M 2026-11 30 random cylinders, pelvis, spine, spleen, random solids]
constexpr double least_spike_apart = 0.1;

// What is done for contours, by arrangement and density; nothing stands for any.
struct EffortRow {
    std::optional<ArrangementKind> arrangement;
    std::optional<PlaneDensity> density;
    bool conforms, fits_sections, recovers;
};

// The first row that applies counts.
constexpr std::array<EffortRow, 7> rows{{
    // All that can be done would take several times as long as the rest.
    {{}, PlaneDensity::crammed, false, false, false},
    // At the poles subsegments are so many and so near to each other that splitting all for each other's
    // sake, and recovering what is missing, costs a hundred times the rest.
    {{}, PlaneDensity::dense_about_axis, false, false, false},
    // No contour runs beside one of another slice; what is missing is a few segments.
    {ArrangementKind::parallel, {}, false, false, true},
    {ArrangementKind::sweep, {}, false, false, true},
    {ArrangementKind::along_paths, {}, false, false, true},
    // A few planes across a stack come near to others only where they cross them: vertices for sections there
    // cost shapes of cells (seven above ratio 4 in a ball) and, where they contradict it, handles.
    {ArrangementKind::stack_and_crossing, {}, true, false, true},
    // About an axis, and in any position.
    {{}, {}, true, true, true},
}};

const EffortRow& row_of(ArrangementKind arrangement, PlaneDensity density) {
    return *std::find_if(rows.begin(), rows.end(), [&](const EffortRow& row) {
        return row.arrangement.value_or(arrangement) == arrangement &&
               row.density.value_or(density) == density;
    });
}

PlaneDensity density_of(const ContourSet& contours, const SliceArrangement& arrangement, double density,
                        std::uint64_t spare_dense_above) {
    // Of sweeps of one extent: the time that all takes goes with it (docs/benchmarks.md).
    const double work = static_cast<double>(contours.points.size()) * density * density;
    if (!(density > dense_above)) return PlaneDensity::sparse;
    if (density > crammed_above || work > static_cast<double>(spare_dense_above))
        return PlaneDensity::crammed;
    const bool at_axis = contours.points.size() > few_points && arrangement.rotation.has_value();
    return at_axis ? PlaneDensity::dense_about_axis : PlaneDensity::dense;
}

ArrangementKind kind_of(const SliceArrangement& arrangement) {
    const bool has_stack = !arrangement.is_stack() && arrangement.parts.has_value();
    return has_stack ? ArrangementKind::stack_and_crossing : arrangement.kind;
}

RefinementEffort refinement_effort(const ContourSet& contours, const Effort& effort,
                                   const RunConfig& config) {
    RefinementEffort refinement;
    refinement.to_short = config.runs_before == 0;
    if (effort.conforming && effort.is_dense()) refinement.deviation_sizes = dense_deviation;
    if (effort.reduced)
        refinement.crowded_sizes = std::min(crowded_share * effort.plane_density, most_crowded_share);
    if (effort.is_parallel() && contours.exclusive) refinement.last_few = last_few_of_labels;
    return refinement;
}

// Each run that was ill-shaped allows less, the fourth nothing.
std::optional<RecoveryEffort> recovery_effort(const Effort& effort, const RunConfig& config) {
    if (config.ill_shaped_before >= recovery_by_failures.size()) return std::nullopt;
    RecoveryEffort recovery = recovery_by_failures[config.ill_shaped_before];
    if (!effort.is_apart()) recovery.least_shape = std::max(recovery.least_shape, least_shape_across);
    if (config.runs_before == 0) recovery.few_missing = few_subsegments;
    return recovery;
}

ImprovementEffort improvement_effort(const Effort& effort) {
    ImprovementEffort improvement;
    if (effort.is_apart()) improvement.least_spike_sizes = least_spike_apart;
    if (effort.is_parallel()) {
        improvement.most_rerouted_sizes = improvement.most_snapped_sizes = most_rerouted_parallel;
        improvement.relabels_for_ratio = true;  // elsewhere pits come of it
        return improvement;
    }
    improvement.most_rerouted_sizes = most_rerouted;
    improvement.most_snapped_sizes = most_sizes_beside;
    improvement.closes_handles = true;
    if (effort.reduced) improvement.sections = SectionRepair::none;
    // Contours are followed, so sections are right. A try at what hardly differs took a minute of the surgery.
    if (effort.arrangement == ArrangementKind::along_paths) improvement.sections = SectionRepair::none;
    return improvement;
}

}  // namespace

Effort effort_of(const ContourSet& contours, const SliceArrangement& arrangement, const StructureField& field,
                 const RunConfig& config) {
    Effort effort;
    effort.plane_density = plane_density(contours, arrangement, field);
    effort.density =
        density_of(contours, arrangement, effort.plane_density, config.options.spare_dense_above);
    effort.arrangement = kind_of(arrangement);
    const EffortRow& row = row_of(effort.arrangement, effort.density);
    // A user who gives a size, and a run after one that was not good enough, get all that can be done.
    effort.reduced = effort.density == PlaneDensity::crammed && config.runs_before == 0 && !config.size_given;
    effort.conforming = row.conforms && config.may_conform;
    effort.fits_sections = row.fits_sections;
    if (effort.reduced) effort.growth = reduced_growth;
    // Contours of planes that cross come so near to each other that a share of the size is far there.
    if (!effort.is_parallel()) {
        effort.tolerance_of_edge = tolerance_of_crossing;
        effort.near_sizes = near_share;
    }
    effort.refinement = refinement_effort(contours, effort, config);
    if (row.recovers) effort.recovery = recovery_effort(effort, config);
    effort.improvement = improvement_effort(effort);
    return effort;
}

Effort effort_at_pole(Effort effort) {
    effort.losses_wait = false;  // waiting costs handles at the pole
    if (effort.recovery) effort.recovery->few_missing = few_subsegments;
    if (effort.reduced) effort.improvement.most_off_surface = most_off_surface_at_pole;
    // All planes are wrong by a little at each cell of the pole, and mending them took three times as long as
    // all the rest.
    if (!effort.is_parallel() && !effort.reduced) effort.improvement.sections = SectionRepair::worst_at_last;
    return effort;
}

}  // namespace anatomesh
