#include "anatomesh/pipeline/effort.h"

#include <algorithm>
#include <array>

#include "anatomesh/improve/reroute/snap_round_segments.h"
#include "anatomesh/sample/sample_points.h"

namespace anatomesh {

namespace {

constexpr double dense_above = 1, crammed_above = 3;  // as plane_density() has it
constexpr std::size_t few_points = 5000;              // about an axis all is done for so many

// Where freehand planes lie closer than the vertices along them, contours tell the surface without more
// points.
constexpr double reduced_growth = 2;  // of the edge length with the depth
// Contour vertices nearer to each other than this may spoil cells, in sizes: more where planes are denser.
constexpr double crowded_share = 0.08, most_crowded_share = 0.25;
// Of the subsegments, off their surface: more are not brought there about an axis where shapes are spared.
constexpr double most_off_surface_at_pole = 0.003;
constexpr double near_share = 0.03;            // where planes cross: as RelabelOptions::near_mm, in sizes
constexpr double tolerance_of_crossing = 0.2;  // where planes cross also in shares of the shortest edge there
// Between dense planes contours leave few vertices of the surface free: more points between them are needed
// to make the volume right.
constexpr double dense_deviation = 0.03;  // in sizes
// Of the cells inside, so many may come above the bound for subsegments' sake at the first runs, and
// cells of no worse shape (cavity.h) are made; after more that were ill-shaped none.
constexpr std::array<RecoveryEffort, 3> recovery_by_failures{{{0.003, 0.01}, {0.001, 0.2}, {0.001, 0.4}}};
constexpr double least_shape_across = 0.1;  // where planes cross: worse ones are not single there
// Subsegments that the recovery leaves no shape untried for: about an axis, and elsewhere at the first run.
constexpr std::size_t few_subsegments = 10;
// Of a label map, slices far apart against its voxels lack more subsegments, where structures meet.
constexpr std::size_t last_few_of_labels = 40;
// Of a contour segment along the surface, from its place, in sizes; and where no planes cross, of which none
// comes too near to another one.
constexpr double most_rerouted = 0.5, most_rerouted_parallel = 0.1;

// What is done for contours, by arrangement and density; nothing stands for any.
struct EffortRow {
    std::optional<ArrangementKind> arrangement;
    std::optional<PlaneDensity> density;
    bool conforms, fits_sections, recovers;
};

// The first row that applies counts.
constexpr std::array<EffortRow, 6> rows{{
    // All that can be done would take several times as long as the rest.
    {{}, PlaneDensity::crammed, false, false, false},
    // At the poles subsegments are so many and so near to each other that splitting all for each other's
    // sake, and recovering what is missing, costs a hundred times the rest.
    {{}, PlaneDensity::dense_about_axis, false, false, false},
    // No contour runs beside one of another slice; what is missing is a few segments.
    {ArrangementKind::parallel, {}, false, false, true},
    {ArrangementKind::sweep, {}, false, false, true},
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
                                   const EffortRequest& request) {
    RefinementEffort refinement;
    refinement.to_short = request.runs_before == 0;
    if (effort.conforming && effort.is_dense()) refinement.deviation_sizes = dense_deviation;
    if (effort.reduced)
        refinement.crowded_sizes = std::min(crowded_share * effort.plane_density, most_crowded_share);
    if (effort.is_parallel() && contours.exclusive) refinement.last_few = last_few_of_labels;
    return refinement;
}

// Each run that was ill-shaped allows less, the fourth nothing.
std::optional<RecoveryEffort> recovery_effort(const Effort& effort, const EffortRequest& request) {
    if (request.ill_shaped_before >= recovery_by_failures.size()) return std::nullopt;
    RecoveryEffort recovery = recovery_by_failures[request.ill_shaped_before];
    if (!effort.is_apart()) recovery.least_shape = std::max(recovery.least_shape, least_shape_across);
    if (request.runs_before == 0) recovery.few_missing = few_subsegments;
    return recovery;
}

ImprovementEffort improvement_effort(const Effort& effort) {
    ImprovementEffort improvement;
    if (effort.is_parallel()) {
        improvement.most_rerouted_sizes = improvement.most_snapped_sizes = most_rerouted_parallel;
        improvement.relabels_for_ratio = true;  // elsewhere pits come of it
        return improvement;
    }
    improvement.most_rerouted_sizes = most_rerouted;
    improvement.most_snapped_sizes = most_sizes_beside;
    improvement.closes_handles = true;
    if (effort.reduced) improvement.sections = SectionRepair::none;
    return improvement;
}

}  // namespace

Effort effort_of(const ContourSet& contours, const SliceArrangement& arrangement, const StructureField& field,
                 const EffortRequest& request) {
    Effort effort;
    effort.plane_density = plane_density(contours, arrangement, field);
    effort.density = density_of(contours, arrangement, effort.plane_density, request.spare_dense_above);
    effort.arrangement = kind_of(arrangement);
    const EffortRow& row = row_of(effort.arrangement, effort.density);
    // A user who gives a size, and a run after one that was not good enough, get all that can be done.
    effort.reduced =
        effort.density == PlaneDensity::crammed && request.runs_before == 0 && !request.size_given;
    effort.conforming = row.conforms && request.may_conform;
    effort.fits_sections = row.fits_sections;
    if (effort.reduced) effort.growth = reduced_growth;
    // Contours of planes that cross come so near to each other that a share of the size is far there.
    if (!effort.is_parallel()) {
        effort.tolerance_of_edge = tolerance_of_crossing;
        effort.near_sizes = near_share;
    }
    effort.refinement = refinement_effort(contours, effort, request);
    if (row.recovers) effort.recovery = recovery_effort(effort, request);
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
