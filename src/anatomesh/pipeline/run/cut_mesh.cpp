#include "anatomesh/pipeline/run/cut_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/recover/recovered_subsegments.h"

namespace anatomesh {

namespace {

// A component smaller than this share of a cube of the size is no part of a structure by itself.
// [1; 0 to 1; M 2026-11, set not recorded]
constexpr double spurious_share = 0.003;
// After the first relabelling so many more follow, with points where a subsegment was given up.
// [rounds; >= 0; B]
constexpr int relabel_rounds = 10;

RelabelOptions relabel_options(const Effort& effort, double size_mm) {
    return {spike_share * size_mm, effort.near_sizes * size_mm, effort.losses_wait};
}

// `look`: empty, or the vertices that may have a defect.
RelabelStats relabel_cells(const PreparedRun& run, double size_mm, GrowingMesh& growing,
                           std::vector<std::uint32_t>& nonmanifold, const std::vector<std::uint32_t>& look,
                           int threads) {
    growing.subsegments.regions_changed();
    LabelledMesh& mesh = growing.mesh;
    const std::size_t vertex_count = mesh.points().size();
    const std::vector<Subsegment>& subsegments = growing.subsegments.subsegments();
    std::optional<VertexStars> stars;
    ContourOwners owners;
    SlicePlanes slices{{}, {}, run.field.get(), run.structures};
    if (run.effort.fits_sections) {
        slices.crossing = crossing_planes(run.slices);
        slices.weights = run.slices.weights;
    }
    PlanesOfStack planes;
    parallel_tasks(threads, {[&] { stars.emplace(mesh.cells().cells, vertex_count, threads); },
                             [&] { owners = owners_of(growing, subsegments, vertex_count); },
                             [&] {
                                 planes =
                                     planes_of_stack(run.contours, run.arrangement(),
                                                     growing.contour_vertices, subsegments, vertex_count);
                             }});
    slices.slice_of = planes.slice_of;
    slices.planes = planes.planes;
    return relabel({mesh.points(), mesh.cells().cells, mesh.cells().neighbors, *stars, owners,
                    mesh.memberships(), mesh.regions(), mesh.registry()},
                   relabel_options(run.effort, size_mm), nonmanifold, look, threads, slices);
}

// What was given up for a manifold's sake gets room beside it: `nonmanifold` receives the vertices left.
Result<RelabelStats> relabel_with_room(const PreparedRun& run, double size_mm, GrowingMesh& growing,
                                       std::vector<std::uint32_t>& nonmanifold, RunContext& context) {
    LabelledMesh& mesh = growing.mesh;
    RelabelStats relabelled = relabel_cells(run, size_mm, growing, nonmanifold, {}, context.threads);
    CellSearch search;
    for (int round = 0; round < relabel_rounds && relabelled.lost_subsegments_after > 0; ++round) {
        mesh.look_again(search);
        search.cells.clear();
        std::vector<std::uint32_t> look = nonmanifold;
        ANATOMESH_TRY(const bool opened, growing.subsegments.open_sides(context, &look));
        if (!opened) break;
        ANATOMESH_CHECK_STATUS(growing.refinement->refine_changed(search, context));
        mesh.look_again(search);
        for (const std::uint32_t c : search.cells)
            look.insert(look.end(), mesh.cells().cells[c].begin(), mesh.cells().cells[c].end());
        sort_distinct(look, mesh.points().size());
        relabelled.add(relabel_cells(run, size_mm, growing, nonmanifold, look, context.threads));
    }
    return relabelled;
}

// The neighbours of the Delaunay mesh, where no cell was split.
std::vector<std::uint32_t> flat_neighbors(const std::vector<CellNeighbors>& cells) {
    std::vector<std::uint32_t> neighbors(4 * cells.size());
    for (std::size_t c = 0; c < cells.size(); ++c)
        std::copy(cells[c].begin(), cells[c].end(), neighbors.begin() + static_cast<std::ptrdiff_t>(4 * c));
    return neighbors;
}

void copy_mesh(const GrowingMesh& growing, WorkingMesh& working, int threads) {
    const LabelledMesh& mesh = growing.mesh;
    parallel_tasks(threads, {[&] { working.neighbors = flat_neighbors(mesh.cells().neighbors); },
                             [&] { working.mesh.cells = mesh.cells().cells; },
                             [&] {
                                 working.mesh.points = mesh.points();
                                 working.mesh.regions = mesh.regions();
                                 working.segment_vertices = growing.subsegments.vertices();
                                 working.subsegments = growing.subsegments.subsegments();
                             }});
}

// What the Delaunay mesh does not have, by exchanging cells. Requires: an effort that recovers.
RecoverStats recover_segments(const PreparedRun& run, const SampleStats& sample, double max_radius_edge,
                              GrowingMesh& growing, WorkingMesh& working,
                              std::vector<std::uint32_t>& nonmanifold, RelabelStats& relabelled,
                              RunContext& context) {
    std::vector<std::uint8_t> held(working.mesh.points.size(), 0);
    const auto vertices = growing.mesh.first_vertices();
    for (std::size_t n = vertices.size() - sample.frame_points; n < vertices.size(); ++n)
        held[vertices[n]] = 1;
    const RelabelOptions relabelling = relabel_options(run.effort, sample.size_mm);
    RecoveryOptions options;
    options.size_mm = sample.size_mm;
    options.tolerance = tolerance_at_vertices(run.effort, sample.size_mm);
    options.max_radius_edge = max_radius_edge;
    options.most_more_bad = run.effort.recovery->most_more_bad;
    options.least_shape = run.effort.recovery->least_shape;
    options.few_missing = run.effort.recovery->few_missing;
    options.near_mm = relabelling.near_mm;
    options.losses_wait = relabelling.losses_wait;
    RecoveredSubsegments recovered(working.mesh, working.neighbors, growing.mesh, *run.field,
                                   {run.contours, run.arrangement(), growing.contour_vertices,
                                    growing.owner_pairs, working.subsegments, std::move(held)},
                                   options);
    recovered.run(nonmanifold, relabelled, context);
    working.subsegments = recovered.subsegments();
    working.segment_vertices.insert(working.segment_vertices.end(), recovered.vertices().begin(),
                                    recovered.vertices().end());
    return recovered.stats();
}

}  // namespace

Status cut_mesh(const PreparedRun& run, const SampleStats& sample, double max_radius_edge,
                GrowingMesh& growing, WorkingMesh& working, CutStats& stats, RunContext& context) {
    std::vector<std::uint32_t> nonmanifold;
    ANATOMESH_TRY(stats.relabelled, relabel_with_room(run, sample.size_mm, growing, nonmanifold, context));
    copy_mesh(growing, working, context.threads);
    TetMesh& mesh = working.mesh;
    RegionRegistry& registry = growing.mesh.registry();
    // Some ms each.
    if (run.effort.recovery)
        stats.recovered = recover_segments(run, sample, max_radius_edge, growing, working, nonmanifold,
                                           stats.relabelled, context);
    const ContourOwners owners = owners_of(growing, working.subsegments, mesh.points.size());
    ANATOMESH_TRY(stats.split, resolve_nonmanifold(mesh, nonmanifold, owners, registry, {}));
    const CutSubsegments& split = stats.split.segments;
    working.segment_vertices.insert(working.segment_vertices.end(), split.vertices.begin(),
                                    split.vertices.end());
    for (const auto& [a, b, structure] : split.subsegments)
        working.cut_subsegments.push_back({a, b, structure, 0});
    if (!nonmanifold.empty())
        working.neighbors = cell_neighbors(mesh.cells, mesh.points.size(), context.threads);
    std::vector<std::uint8_t> given = growing.given;
    given.resize(mesh.points.size(), 0);
    working.regions = registry.table();
    stats.spurious = drop_spurious_components(run, sample.size_mm, given, working, context.threads);
    return Nothing{};
}

SpuriousComponentStats drop_spurious_components(const PreparedRun& run, double size_mm,
                                                std::span<const std::uint8_t> given, WorkingMesh& working,
                                                int threads) {
    const ContourSet& contours = run.contours;
    // Of outlines beside each other on parallel planes, each with its own, what is between several is a
    // wedge, whose cells would be no better.
    const bool gave_overlaps = contours.exclusive && contours.drawn;
    const bool may_be_between = gave_overlaps || contours.overlapping || !run.effort.is_parallel();
    return remove_spurious_components(working.mesh, working.neighbors, given,
                                      {spurious_share * std::pow(size_mm, 3)}, threads,
                                      may_be_between ? &working.regions : nullptr);
}

}  // namespace anatomesh
