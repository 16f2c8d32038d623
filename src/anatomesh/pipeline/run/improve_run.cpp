#include "anatomesh/pipeline/run/improve_run.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/improve/reroute/routed_contours.h"
#include "anatomesh/pipeline/run/cut_mesh.h"
#include "anatomesh/pipeline/run/ill_shaped_cells.h"
#include "anatomesh/pipeline/run/improve_angles.h"

namespace anatomesh {

namespace {

// For the volume's sake no vertex moves further than this. [sizes; > 0; M 2026-11 ellipsoid on 36 planes]
constexpr double balance_reach = 0.1;
// Where a volume is still amiss by more than this share, vertices move once more.
// [1; 0 to 0.002; M 2026-11 few contours on dense planes]
constexpr double most_amiss = 0.0015;
// The second time they move by no more: where few vertices are free, that makes bumps of them.
// [sizes; > 0; M 2026-11 few contours on dense planes]
constexpr double further_reach = 0.15;
// The last smoothing goes on above this mean radius-edge ratio: 0.95 is asked for, and what comes after it
// takes a little of that. [1; 0.6 to 2; M 2026-11 models of few thick slices]
constexpr double smooth_mean = 0.947;

// Contour vertices, points on contour segments and the frame stay where they are.
std::vector<std::uint8_t> fixed_vertices(const ImproveInput& input, const WorkingMesh& working) {
    std::vector<std::uint8_t> fixed(working.mesh.points.size(), 0);
    const SampleStats& sample = input.sample;
    const auto vertices = input.growing.mesh.first_vertices();
    for (std::size_t n = 0; n < sample.contour_points + sample.segment_points; ++n) fixed[vertices[n]] = 1;
    for (const std::uint32_t v : working.segment_vertices) fixed[v] = 1;
    for (std::size_t n = vertices.size() - sample.frame_points; n < vertices.size(); ++n)
        fixed[vertices[n]] = 1;
    return fixed;
}

// The vertices of ill-shaped cells are fixed: the rest at such a vertex is as it is for what forces them, and
// the worst of all would be what it may come to.
void fix_ill_shaped(const TetMesh& mesh, int threads, std::vector<std::uint8_t>& fixed) {
    for (const std::uint32_t c : ill_shaped_cells(mesh, threads)) {
        for (const std::uint32_t v : mesh.cells[c]) fixed[v] = 1;
    }
}

VertexStars stars_of(const TetMesh& mesh, int threads) {
    return VertexStars(mesh.cells, mesh.points.size(), threads);
}

ImproveStats bring_onto_interface(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                                  const VertexStars& stars, const std::vector<std::uint8_t>& fixed,
                                  RunContext& context) {
    ImproveOptions options;
    options.max_radius_edge = input.options.max_radius_edge;
    options.tolerance_mm = interface_tolerance * input.sample.size_mm;
    if (run.effort.reduced) options.rounds = 0;
    return improve(working.mesh, stars, fixed, *run.field, run.structures, working.regions, options, context);
}

SmoothOptions smooth_options(const ImproveInput& input) {
    SmoothOptions options;
    options.max_mean = HUGE_VAL;
    options.max_radius_edge = input.options.max_radius_edge;
    options.tolerance_mm = interface_tolerance * input.sample.size_mm;
    options.max_deviation_mm = surface_deviation * input.sample.size_mm;
    return options;
}

SmoothStats smooth_all(const PreparedRun& run, WorkingMesh& working, const VertexStars& stars,
                       const std::vector<std::uint8_t>& fixed, const SmoothOptions& options,
                       RunContext& context) {
    return smooth_vertices({working.mesh, working.neighbors, stars, fixed, working.regions}, *run.field,
                           run.structures, options, context);
}

Status find_volumes(PreparedRun& run, RunContext& context) {
    if (!run.known.volumes.empty()) return Nothing{};
    ANATOMESH_TRY(run.known.volumes, field_volumes(*run.field, run.structures, {}, context));
    return Nothing{};
}

// Re-routed contours are sound where the model will lie, or stay as they are drawn;
// spurious components that they left go.
SpuriousComponentStats settle_routed(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                                     std::vector<RoutedContour>& routed, int threads) {
    if (routed.empty()) return {};
    const std::vector<std::uint32_t>& vertices = input.growing.contour_vertices;
    std::vector<Vec3> points = working.mesh.points;
    move_back(run.origin, points);
    for (std::size_t n = 0; n < vertices.size(); ++n) points[vertices[n]] = input.source.points[n];
    drop_unsound(input.source, routed, points);
    return drop_spurious_components(run, input.sample.size_mm,
                                    kept_vertices(run.contours, vertices, routed, points.size()), working,
                                    threads);
}

BalanceStats balance(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                     const VertexStars& stars, const std::vector<std::uint8_t>& fixed,
                     const PlaneSides& sides, int threads) {
    const std::vector<double> volumes_mm3 = volumes_by_field(run.known.volumes);
    const double size_mm = input.sample.size_mm;
    BalanceOptions options;
    options.max_radius_edge = input.options.max_radius_edge;
    options.ends = run.field->flat_ends();
    options.slices = sides;
    options.end_tolerance_mm = interface_tolerance * size_mm;
    const auto balanced_within = [&](double reach) {
        options.max_offset_mm = reach * size_mm;
        return balance_volumes({working.mesh, working.neighbors, stars, fixed, working.regions}, volumes_mm3,
                               options, threads);
    };
    BalanceStats balanced = balanced_within(balance_reach);
    if (balanced.worst_after > most_amiss) {
        const BalanceStats first = balanced;
        balanced = balanced_within(further_reach);
        balanced.moves += first.moves;
        balanced.largest_offset_mm += first.largest_offset_mm;
        balanced.worst_before = first.worst_before;
    }
    return balanced;
}

}  // namespace

Result<ImprovedStats> improve_run(PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                                  RoutedRun& routed, RunContext& context) {
    std::vector<std::uint8_t> fixed = fixed_vertices(input, working);
    ImprovedStats stats;
    std::optional<VertexStars> stars(stars_of(working.mesh, context.threads));
    stats.improved = bring_onto_interface(run, input, working, *stars, fixed, context);
    // Before, so that fewer angles are bad; after, since flips leave room.
    SmoothOptions smoothing = smooth_options(input);
    stats.smoothed = smooth_all(run, working, *stars, fixed, smoothing, context);
    stars.reset();
    // Much of that is serial: the field's volumes are found beside it.
    Status volumes = Nothing{};
    parallel_tasks(context.threads,
                   {[&] { stats.dihedrals = improve_angles(run, input, working, fixed, context); },
                    [&] { volumes = find_volumes(run, context); }});
    ANATOMESH_CHECK_STATUS(volumes);
    routed.contours = std::move(stats.dihedrals.routed);
    routed.segments_missed = stats.dihedrals.segments_missed;
    stats.spurious = settle_routed(run, input, working, routed.contours, context.threads);
    stats.contours_routed = routed.contours.size();
    stars = stars_of(working.mesh, context.threads);
    fix_ill_shaped(working.mesh, context.threads, fixed);
    // Those mended at last too: that would be undone.
    const SliceWeights slices = slices_to_keep(run);
    // No vertex of an interface passes through the slices.
    smoothing.slices = slices.sides;
    smoothing.max_mean = smooth_mean;
    const SmoothStats again = smooth_all(run, working, *stars, fixed, smoothing, context);
    stats.smoothed.vertices_moved += again.vertices_moved;
    stats.smoothed.surface_vertices_moved += again.surface_vertices_moved;
    stats.balanced = balance(run, input, working, *stars, fixed, slices.sides, context.threads);
    return stats;
}

double most_reroute_mm(const ModelOptions& options, double sizes, double size_mm) {
    return std::min(options.max_reroute_mm, sizes * size_mm);
}

std::vector<double> volumes_by_field(const std::vector<StructureVolume>& volumes) {
    std::vector<double> by_field;
    for (const StructureVolume& volume : volumes) by_field.push_back(volume.by_field);
    return by_field;
}

}  // namespace anatomesh
