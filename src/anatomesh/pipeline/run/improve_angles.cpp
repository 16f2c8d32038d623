#include "anatomesh/pipeline/run/improve_angles.h"

#include <array>
#include <span>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/improve_mesh.h"
#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/mesh/check/spurious_handles.h"
#include "anatomesh/refine/missing_segments.h"

namespace anatomesh {

namespace {

// At reduced effort cells with smaller dihedral angles are improved.
// [degrees; 0 to 40; M 2026-11 dense freehand planes]
constexpr double reduced_target_degrees = 2.5;

MeshImprovementOptions improvement_options(const Effort& effort, double max_radius_edge, double size_mm) {
    MeshImprovementOptions options;
    options.max_radius_edge = max_radius_edge;
    options.tolerance_mm = interface_tolerance * size_mm;
    options.max_deviation_mm = surface_deviation * size_mm;
    options.spike_mm = spike_height * size_mm;
    options.least_spike_mm = effort.improvement.least_spike_sizes * size_mm;
    options.relabels_for_ratio = effort.improvement.relabels_for_ratio;
    if (effort.improvement.closes_handles) options.handle_mm = spurious_handle_reach * size_mm;
    if (effort.reduced) {
        options.target_degrees = reduced_target_degrees;
        options.passes = 1;
        options.ratio_passes = 0;
        options.last_deviation = 1;  // the one pass is the last
    }
    return options;
}

// Two vertices and a structure of each subsegment that has cells on one side of its structure alone; none
// where these are more than the effort brings onto the surface.
std::vector<std::array<std::uint32_t, 3>> off_surface(const PreparedRun& run, const WorkingMesh& working,
                                                      const std::vector<Subsegment>& subsegments,
                                                      int threads) {
    const TetMesh& mesh = working.mesh;
    const std::vector<SubsegmentSides> sides =
        subsegment_sides(mesh.cells, mesh.regions, working.regions, mesh.points.size(), subsegments, threads);
    std::vector<std::array<std::uint32_t, 3>> off;
    for (std::size_t n = 0; n < subsegments.size(); ++n) {
        if (sides[n].inside != sides[n].outside)
            off.push_back({subsegments[n].a, subsegments[n].b, subsegments[n].structure});
    }
    const double most = run.effort.improvement.most_off_surface * static_cast<double>(subsegments.size());
    if (static_cast<double>(off.size()) > most) off.clear();
    return off;
}

// By vertex; those of contours and of subsegments of their segments are looked at.
std::vector<std::uint8_t> constraint_limited(const PreparedRun& run,
                                             const std::vector<std::uint32_t>& contour_vertices,
                                             const std::vector<Subsegment>& subsegments,
                                             const TetMesh& mesh) {
    std::vector<std::uint32_t> vertices = contour_vertices;
    for (const Subsegment& subsegment : subsegments)
        vertices.insert(vertices.end(), {subsegment.a, subsegment.b});
    sort_distinct(vertices, mesh.points.size());
    return constraint_limited_vertices(mesh, run.contours, contour_vertices, vertices,
                                       contract::forcing_share);
}

}  // namespace

SliceWeights slices_to_keep(const PreparedRun& run) {
    return run.effort.improvement.sections == SectionRepair::none ? SliceWeights{} : run.slices;
}

MeshImprovementStats improve_angles(const PreparedRun& run, const ImproveInput& input, WorkingMesh& working,
                                    std::vector<std::uint8_t>& fixed, RunContext& context) {
    TetMesh& mesh = working.mesh;
    const Effort& effort = run.effort;
    const double size_mm = input.sample.size_mm;
    const std::vector<std::uint32_t>& contour_vertices = input.growing.contour_vertices;
    std::vector<Subsegment> subsegments = working.subsegments;
    subsegments.insert(subsegments.end(), working.cut_subsegments.begin(), working.cut_subsegments.end());
    const std::vector<std::uint32_t> slice_of =
        slices_of_vertices(run.contours, contour_vertices, working.subsegments, mesh.points.size());
    const ContourOwners owners = owners_of(input.growing, subsegments, mesh.points.size());
    const auto beside = off_surface(run, working, subsegments, context.threads);
    std::vector<std::uint8_t> limited;
    if (!effort.reduced || !beside.empty())
        limited = constraint_limited(run, contour_vertices, subsegments, mesh);
    const SliceWeights slices = slices_to_keep(run);
    const bool worst_alone = effort.improvement.sections == SectionRepair::worst_at_last;
    std::vector<Plane> planes;
    for (const Slice& slice : run.contours.slices) planes.push_back(slice.plane);
    const RoutableContours routable{
        run.contours.contours, contour_vertices, planes, run.contours.exclusive,
        most_reroute_mm(input.options, effort.improvement.most_rerouted_sizes, size_mm)};
    const std::vector<VertexPair> fixed_edges =
        edges_along(mesh, working.neighbors, segment_ends(run.contours, contour_vertices));
    return improve_mesh(
        mesh, working.neighbors, {fixed, fixed_edges}, *run.field, run.structures,
        {&working.regions, slice_of, &owners, slices.planes, slices.extents, slices.weights,
         slices.on_plane_mm, worst_alone ? contract::section_tolerance : 0.0, beside, limited, routable},
        improvement_options(effort, input.options.max_radius_edge, size_mm), context);
}

}  // namespace anatomesh
