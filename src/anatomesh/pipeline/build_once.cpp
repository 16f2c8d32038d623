#include "anatomesh/pipeline/build_once.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/model/message_text.h"
#include "anatomesh/cut/relabel.h"
#include "anatomesh/cut/resolve_nonmanifold.h"
#include "anatomesh/cut/spurious_components.h"
#include "anatomesh/field/make_structure_field.h"
#include "anatomesh/field/model/counted_field.h"
#include "anatomesh/field/model/volume.h"
#include "anatomesh/improve/improve_mesh.h"
#include "anatomesh/improve/operations/segment_edges.h"
#include "anatomesh/improve/reroute/routed_contours.h"
#include "anatomesh/improve/reroute/snap_round_segments.h"
#include "anatomesh/improve/smooth/balance_volumes.h"
#include "anatomesh/improve/smooth/improve.h"
#include "anatomesh/improve/smooth/smooth_vertices.h"
#include "anatomesh/measure/certificate.h"
#include "anatomesh/measure/contour_fidelity.h"
#include "anatomesh/measure/topology/topology_warnings.h"
#include "anatomesh/mesh/check/spurious_handles.h"
#include "anatomesh/mesh/check/topology.h"
#include "anatomesh/mesh/edit/drop_outside.h"
#include "anatomesh/mesh/edit/facets.h"
#include "anatomesh/pipeline/contour_field.h"
#include "anatomesh/pipeline/contradicted_places.h"
#include "anatomesh/pipeline/effort.h"
#include "anatomesh/pipeline/ill_shaped_cells.h"
#include "anatomesh/pipeline/improve_figures.h"
#include "anatomesh/pipeline/model_warnings.h"
#include "anatomesh/recover/recovered_subsegments.h"
#include "anatomesh/refine/contour_subsegments.h"
#include "anatomesh/refine/labelled_mesh.h"
#include "anatomesh/refine/missing_segments.h"
#include "anatomesh/refine/refinement_rounds.h"
#include "anatomesh/refine/segment_vertices.h"
#include "anatomesh/sample/sample_points.h"

namespace anatomesh {

namespace {

constexpr double interface_tolerance = 0.02;  // points this near an interface count as on it, in sizes
// For the volume's sake no vertex moves further than the first of these, in sizes, and, where a larger share
// of a volume is still amiss then, the second further: where few vertices are free, that makes bumps of them.
constexpr double balance_reach = 0.1, further_reach = 0.15;
constexpr double most_amiss = 0.0015;
constexpr double surface_deviation =
    0.06;                                 // of the middle of an interface facet from the interface, in sizes
constexpr double hardly_thicker = 1.3;    // than the size: a structure that a finer one may keep whole
constexpr double spike_height = 0.35;     // of a surface over the field's, in sizes
constexpr double spurious_share = 0.003;  // of a cube of the size: less is no piece of a structure by itself
constexpr int relabel_rounds = 10;        // after the first, with points where a subsegment was given up
// A surface so far from the field's, in sizes, is one of bumps and pits.
constexpr double most_astray = 0.3;
// Radius-edge ratio inside: 0.95 is asked for, and what comes after the last smoothing takes a little of it.
constexpr double smooth_mean = 0.947;
constexpr double dense_target_degrees = 2.5;  // of dihedral angles

// Everything that one run of the method carries from stage to stage. The stages work relative to the low
// corner of the contours' box: far from (0, 0, 0) coordinates are coarse, and a model must not depend on
// where the patient lay.
class Builder {
  public:
    // `known`: of the run before, or empty. Requires: all outlive this.
    Builder(const ContourSet& contours, const RunConfig& config, RunContext& context,
            const StageObserver& observer, FieldAndVolumes known)
        : source_(contours),
          origin_(contours.points.empty() ? Vec3{} : contours.box().low),
          contours_(relative_to(origin_, contours)),
          options_(config.options),
          request_{config.options.spare_dense_above, config.size_given, config.may_conform, config.before,
                   config.ill_shaped_before},
          target_mean_ratio_(config.target_mean_ratio),
          context_(context),
          observer_(observer),
          structures_(static_cast<std::uint32_t>(contours.structures.size())),
          facts_(std::move(known.slices)),
          known_field_(std::move(known.field)),
          volumes_(std::move(known.volumes)) {}

    FieldAndVolumes field_and_volumes() const { return {facts_, known_field_, volumes_, warnings_of_field_}; }

    double size_mm() const { return sample_ ? sample_->stats.size_mm : 0; }

    WorkReport work() const {
        return {1, mesh_ ? mesh_->cells_made() : 0, edited_cells_,
                counted_field_ ? counted_field_->values() : 0};
    }

    RunScore score(const Result<Model>& model) const {
        RunFacts facts;
        facts.size_mm = size_mm();
        facts.cells = model.ok() ? model.value().mesh.cells.size() : cells_so_far();
        // The same size is to be tried again with all that can be done.
        facts.reduced_effort = effort_.reduced || recovered_ || (subsegments_ && subsegments_->are_short());
        facts.conformed = effort_.conforming;
        facts.segments_missed = segments_missed_;
        facts.has_segments_beside = has_segments_beside_;
        facts.drawn_segments = source_.points.size();
        // Or it was not looked at.
        facts.contradicted = !effort_.is_apart() && (!effort_.fits_sections || !contradicted_.empty());
        const ModelReport& report = model.ok() ? model.value().report : model_.report;
        if (model.ok()) {
            facts.torn = tore_a_structure();
            facts.spurious_joints = spurious_places(tears_);
            facts.deviates = effort_.conforming && effort_.is_dense() &&
                             report.field_distance.max_mm > most_astray * size_mm();
        }
        return score_of(model, report, facts);
    }

    Result<Model> run() {
        ANATOMESH_CHECK_STATUS(make_field());
        ANATOMESH_CHECK_STATUS(sample());
        ANATOMESH_CHECK_STATUS(tetrahedralize());
        ANATOMESH_CHECK_STATUS(cull_cells());
        ANATOMESH_CHECK_STATUS(refine_cells());
        ANATOMESH_CHECK_STATUS(cut_cells());
        ANATOMESH_CHECK_STATUS(improve_cells());
        drop_outside_cells();
        ANATOMESH_CHECK_STATUS(certify());
        return std::move(model_);
    }

  private:
    using Clock = std::chrono::steady_clock;

    std::size_t cells_so_far() const {
        return !model_.mesh.cells.empty() ? model_.mesh.cells.size() : mesh_ ? mesh_->regions().size() : 0;
    }

    // Whether the mesh tore a structure that a finer size may keep whole: one hardly thicker than the size,
    // or one that goes on simply from end to end.
    bool tore_a_structure() const {
        const std::vector<double> thickness = mean_thickness(contours_);
        return std::any_of(
            tears_.of_slices.begin(), tears_.of_slices.end(), [&](const TopologyMismatch& tear) {
                return tear.by_mesh && (tear.whole || thickness[tear.structure] < hardly_thicker * size_mm());
            });
    }

    Status make_field() {
        FieldOptions options;
        options.caps = options_.caps;
        options.max_gap_spacings = options_.max_gap_spacings;
        options.single_slice_mm = options_.single_slice_mm;
        if (!known_field_) {
            ANATOMESH_TRY(known_field_, make_structure_field(contours_, *facts_, options, context_));
        }
        field_ = known_field_;
        if (context_.threads == 1) field_ = counted_field_ = std::make_shared<CountedField>(known_field_);
        warnings_of_field_ = context_.warnings.size();
        report().slice_spacing_mm = field_->slice_spacing();
        effort_ = effort_of(contours_, arrangement(), *field_, request_);
        slices_ = weigh_slices(contours_, *facts_, field_->flat_ends());
        if (effort_.fits_sections) contradicted_ = contradicted_places(contours_, slices_.weights, context_);
        return end_stage("field", 0.05);
    }

    Status sample() {
        SampleOptions options;
        options.size_mm = options_.size_mm;
        options.conforming = effort_.conforming;
        options.growth = effort_.growth;
        ANATOMESH_TRY(sample_, sample_points(contours_, arrangement(), *field_, options, context_));
        if (sample_->has_pole) effort_ = effort_at_pole(effort_);
        const SampleStats& stats = sample_->stats;
        figures_ = {{"contour_points", static_cast<double>(stats.contour_points)},
                    {"segment_points", static_cast<double>(stats.segment_points)},
                    {"thin_spots", static_cast<double>(stats.thin_spots)},
                    {"surface_points", static_cast<double>(stats.surface_points)},
                    {"lattice_points", static_cast<double>(stats.lattice_points)}};
        report().size_mm = stats.size_mm;
        warn_of_thin_structures(contours_, mean_thickness(contours_), stats.size_mm, context_);
        // About six cells a point come of a Delaunay mesh; refuse before the work.
        if (6 * sample_->points.size() > options_.max_tetrahedra || 6 * sample_->points.size() >= no_cell) {
            return Error{ErrorKind::limit,
                         "E-PIP-001",
                         "the model would need about " + std::to_string(6 * sample_->points.size()) +
                             " tetrahedra, more than " +
                             std::to_string(std::min<std::uint64_t>(options_.max_tetrahedra, no_cell)),
                         {},
                         "give a larger --size"};
        }
        return end_stage("sample", 0.15);
    }

    Status tetrahedralize() {
        ANATOMESH_TRY(Tetrahedralization delaunay,
                      Tetrahedralization::create(sample_->points, context_.threads));
        mesh_.emplace(std::move(delaunay), *field_, structures_, sample_->stats.size_mm,
                      tolerance_at_vertices());
        // The mesh's vertex of every contour point, and the structures it must have on its surface.
        std::vector<std::array<std::uint32_t, 2>> owners;
        for (const Contour& contour : contours_.contours) {
            for (std::uint32_t n = contour.first_point; n < contour.first_point + contour.point_count; ++n) {
                owners.push_back({mesh_->first_vertices()[sample_->contour_vertices[n]], contour.structure});
            }
        }
        owner_pairs_ = std::move(owners);
        const auto vertices = mesh_->first_vertices();
        std::vector<Subsegment> subsegments;
        for (const Subsegment& subsegment : sample_->subsegments) {
            subsegments.push_back(
                {vertices[subsegment.a], vertices[subsegment.b], subsegment.structure, subsegment.ball});
        }
        ContourSubsegmentOptions options{
            sample_->stats.size_mm,     effort_.reduced, effort_.is_dense_in_full(),
            effort_.conforming,         sample_->graded, effort_.refinement.to_short,
            effort_.refinement.last_few};
        subsegments_.emplace(*mesh_, sample_->protected_segments, *field_, std::move(subsegments), options);
        given_.assign(mesh_->points().size(), 0);
        for (std::size_t n = 0; n < sample_->stats.contour_points; ++n) given_[vertices[n]] = 1;
        return end_stage("delaunay", 0.35);
    }

    Status cull_cells() {
        const CullStats stats = mesh_->update(context_);
        ANATOMESH_CHECK_STATUS(check_region_count(*mesh_));
        report().share_culled =
            static_cast<double>(stats.culled) / static_cast<double>(mesh_->regions().size());
        figures_ = {{"cells", static_cast<double>(mesh_->regions().size())},
                    {"culled", static_cast<double>(stats.culled)},
                    {"culled_share", report().share_culled}};
        return end_stage("cull", 0.45);
    }

    Status refine_cells() {
        const double size_mm = sample_->stats.size_mm;
        RefinementOptions options{size_mm,
                                  options_.max_radius_edge,
                                  effort_.refinement.crowded_sizes * size_mm,
                                  effort_.refinement.deviation_sizes * size_mm,
                                  effort_.reduced,
                                  effort_.conforming,
                                  sample_->graded,
                                  target_mean_ratio_,
                                  {}};
        if (effort_.fits_sections) options.slices = {crossing_planes(), slices_.weights, contradicted_};
        refinement_.emplace(*mesh_, *subsegments_, sample_->protected_segments, given_, options);
        ANATOMESH_CHECK_STATUS(refinement_->run(context_));
        const RefinementStats& stats = refinement_->stats();
        report().radius_edge_mean_before_refinement = stats.radius_edge_mean_before;
        figures_ = {{"crossing_points", static_cast<double>(stats.crossing_points)},
                    {"deviation_points", static_cast<double>(stats.deviation_points)},
                    {"cut_points", static_cast<double>(stats.section_points)},
                    {"circumcenters", static_cast<double>(stats.circumcenters)},
                    {"surface_points", static_cast<double>(stats.surface_points)},
                    {"side_points", static_cast<double>(subsegments_->side_points())},
                    {"segment_points", static_cast<double>(subsegments_->vertices().size())}};
        return end_stage("refine", 0.6);
    }

    SurfaceTolerance tolerance_at_vertices() const {
        return {interface_tolerance * sample_->stats.size_mm, effort_.tolerance_of_edge};
    }

    double near_mm() const { return effort_.near_sizes * sample_->stats.size_mm; }

    ContourOwners contour_owners(const std::vector<Subsegment>& all, std::size_t point_count) const {
        std::vector<std::array<std::uint32_t, 3>> subsegments;
        for (const Subsegment& subsegment : all)
            subsegments.push_back({subsegment.a, subsegment.b, subsegment.structure});
        return {owner_pairs_, point_count, subsegments};
    }

    // `look`: empty, or the vertices that may have a defect.
    RelabelStats relabel_cells(std::vector<std::uint32_t>& nonmanifold,
                               const std::vector<std::uint32_t>& look = {}) {
        subsegments_->regions_changed();
        const std::size_t vertex_count = mesh_->points().size();
        std::optional<VertexStars> stars;
        ContourOwners owners;
        SlicePlanes slices{{}, {}, field_.get(), structures_};
        if (effort_.fits_sections) slices.crossing = crossing_planes(), slices.weights = slices_.weights;
        PlanesOfStack planes;
        parallel_tasks(context_.threads,
                       {[&] { stars.emplace(mesh_->cells().cells, vertex_count, context_.threads); },
                        [&] { owners = contour_owners(subsegments_->subsegments(), vertex_count); },
                        [&] {
                            planes = planes_of_stack(contours_, arrangement(), vertices_of_contours(),
                                                     subsegments_->subsegments(), vertex_count);
                        }});
        slices.slice_of = planes.slice_of;
        slices.planes = planes.planes;
        return relabel({mesh_->points(), mesh_->cells().cells, mesh_->cells().neighbors, *stars, owners,
                        mesh_->memberships(), mesh_->regions(), mesh_->registry()},
                       {spike_share * sample_->stats.size_mm, near_mm(), effort_.losses_wait}, nonmanifold,
                       look, context_.threads, slices);
    }

    Status cut_cells() {
        std::vector<std::uint32_t> nonmanifold;
        RelabelStats relabelled = relabel_cells(nonmanifold);
        // What was given up for a manifold's sake gets room beside it.
        CellSearch search;
        for (int round = 0; round < relabel_rounds && relabelled.lost_subsegments_after > 0; ++round) {
            mesh_->look_again(search);
            search.cells.clear();
            std::vector<std::uint32_t> look = nonmanifold;
            ANATOMESH_TRY(const bool opened, subsegments_->open_sides(context_, &look));
            if (!opened) break;
            ANATOMESH_CHECK_STATUS(refinement_->refine_changed(search, context_));
            mesh_->look_again(search);
            for (const std::uint32_t c : search.cells) {
                look.insert(look.end(), mesh_->cells().cells[c].begin(), mesh_->cells().cells[c].end());
            }
            sort_distinct(look, mesh_->points().size());
            relabelled.add(relabel_cells(nonmanifold, look));
        }
        TetMesh& mesh = model_.mesh;
        parallel_tasks(context_.threads,
                       {[&] { find_neighbors(true); }, [&] { mesh.cells = mesh_->cells().cells; },
                        [&] {
                            mesh.points = mesh_->points();
                            mesh.regions = mesh_->regions();
                            segment_vertices_ = subsegments_->vertices();
                            subsegment_list_ = subsegments_->subsegments();
                        }});
        RecoverStats recovered;
        // Some ms each.
        if (effort_.recovery) recovered = recover_segments(nonmanifold, relabelled);
        const ContourOwners owners = contour_owners(subsegment_list_, mesh.points.size());
        ANATOMESH_TRY(const NonmanifoldStats split,
                      resolve_nonmanifold(mesh, nonmanifold, owners, mesh_->registry(), {}));
        segment_vertices_.insert(segment_vertices_.end(), split.segments.vertices.begin(),
                                 split.segments.vertices.end());
        for (const auto& [a, b, structure] : split.segments.subsegments)
            cut_subsegments_.push_back({a, b, structure, 0});
        if (!nonmanifold.empty()) find_neighbors(false);
        given_.resize(mesh.points.size(), 0);
        const SpuriousComponentStats spurious = drop_spurious_components(given_);
        model_.regions = mesh_->registry().table();
        figures_ = {{"unsound_vertices", static_cast<double>(relabelled.nonmanifold_before)},
                    {"cells_moved", static_cast<double>(relabelled.cells_moved)},
                    {"cells_mended", static_cast<double>(relabelled.cells_mended)},
                    {"flat_cells_peeled", static_cast<double>(relabelled.flat_cells_peeled)},
                    {"lost_pieces", static_cast<double>(relabelled.lost_subsegments_before)},
                    {"lost_pieces_after_relabelling", static_cast<double>(relabelled.lost_subsegments_after)},
                    {"missing_pieces", static_cast<double>(recovered.missing_before)},
                    {"missing_pieces_after", static_cast<double>(recovered.missing_after)},
                    {"recovered_by_vertices", static_cast<double>(recovered.vertices_added)},
                    {"unsound_after_relabelling", static_cast<double>(relabelled.nonmanifold_after)},
                    {"edges_split", static_cast<double>(split.edges_split)},
                    {"vertices_split", static_cast<double>(split.vertices_split)},
                    {"vertices_joined", static_cast<double>(split.vertices_joined)},
                    {"pieces_given", static_cast<double>(split.components_relabelled)},
                    {"crumbs_given_away", static_cast<double>(spurious.components)}};
        return end_stage("cut", 0.75);
    }

    SpuriousComponentStats drop_spurious_components(std::span<const std::uint8_t> given) {
        // Of outlines beside each other on parallel planes, each with its own, what is between several is a
        // wedge, whose cells would be no better.
        const bool gave_overlaps = contours_.exclusive && contours_.drawn;
        const bool may_be_between = gave_overlaps || contours_.overlapping || !effort_.is_parallel();
        const RegionTable* table = may_be_between ? &mesh_->registry().table() : nullptr;
        return remove_spurious_components(model_.mesh, neighbors_, given,
                                          {spurious_share * std::pow(sample_->stats.size_mm, 3)},
                                          context_.threads, table);
    }

    // What the Delaunay mesh does not have, by exchanging cells.
    RecoverStats recover_segments(std::vector<std::uint32_t>& nonmanifold, RelabelStats& relabelled) {
        std::vector<std::uint8_t> held(model_.mesh.points.size(), 0);
        const auto vertices = mesh_->first_vertices();
        for (std::size_t n = vertices.size() - sample_->stats.frame_points; n < vertices.size(); ++n)
            held[vertices[n]] = 1;
        RecoveredSubsegments recovered(
            model_.mesh, neighbors_, *mesh_, *field_,
            {contours_, arrangement(), vertices_of_contours(), owner_pairs_, subsegment_list_,
             std::move(held)},
            {sample_->stats.size_mm, tolerance_at_vertices(), options_.max_radius_edge,
             effort_.recovery->most_more_bad, effort_.recovery->least_shape, effort_.recovery->few_missing,
             near_mm(), effort_.losses_wait});
        recovered.run(nonmanifold, relabelled, context_);
        subsegment_list_ = recovered.subsegments();
        segment_vertices_.insert(segment_vertices_.end(), recovered.vertices().begin(),
                                 recovered.vertices().end());
        recovered_ = recovered.stats().missing_after < recovered.stats().missing_before;
        return recovered.stats();
    }

    std::vector<std::uint32_t> vertices_of_contours() const {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t n : sample_->contour_vertices)
            vertices.push_back(mesh_->first_vertices()[n]);
        return vertices;
    }

    // Those of the Delaunay mesh, where no cell was split.
    void find_neighbors(bool as_before) {
        if (!as_before) {
            neighbors_ = cell_neighbors(model_.mesh.cells, model_.mesh.points.size(), context_.threads);
            return;
        }
        const std::vector<CellNeighbors>& cells = mesh_->cells().neighbors;
        neighbors_.resize(4 * cells.size());
        for (std::size_t c = 0; c < cells.size(); ++c)
            std::copy(cells[c].begin(), cells[c].end(),
                      neighbors_.begin() + static_cast<std::ptrdiff_t>(4 * c));
    }

    Status improve_cells() {
        // Contour vertices, points on contour segments and the frame stay where they are.
        std::vector<std::uint8_t> fixed(model_.mesh.points.size(), 0);
        const SampleStats& stats = sample_->stats;
        const auto vertices = mesh_->first_vertices();
        for (std::size_t n = 0; n < stats.contour_points + stats.segment_points; ++n) fixed[vertices[n]] = 1;
        for (const std::uint32_t v : segment_vertices_) fixed[v] = 1;
        for (std::size_t n = vertices.size() - stats.frame_points; n < vertices.size(); ++n)
            fixed[vertices[n]] = 1;
        ImproveOptions options;
        options.max_radius_edge = options_.max_radius_edge;
        options.tolerance_mm = interface_tolerance * stats.size_mm;
        if (effort_.reduced) options.rounds = 0;
        std::optional<VertexStars> stars(find_stars());
        const ImproveStats improved =
            improve(model_.mesh, *stars, fixed, *field_, structures_, model_.regions, options, context_);
        // Before, so that fewer angles are bad; after, since flips leave room.
        SmoothStats smoothed = smooth_all(*stars, fixed, {});
        stars.reset();
        // Much of that is serial: the field's volumes are found beside it.
        MeshImprovementStats dihedrals;
        Status volumes = Nothing{};
        parallel_tasks(context_.threads,
                       {[&] { dihedrals = improve_angles(fixed); }, [&] { volumes = find_volumes(); }});
        ANATOMESH_CHECK_STATUS(volumes);
        routed_ = std::move(dihedrals.routed);
        segments_missed_ = dihedrals.segments_missed;
        edited_cells_ = dihedrals.cells_made;
        const SpuriousComponentStats spurious = settle_routed();
        stars = find_stars();
        fix_ill_shaped(fixed);
        // Those mended at last too: that would be undone.
        const SliceWeights slices = slices_to_keep();
        const SmoothStats again = smooth_all(*stars, fixed, slices.sides, smooth_mean);
        smoothed.vertices_moved += again.vertices_moved;
        smoothed.surface_vertices_moved += again.surface_vertices_moved;
        BalanceOptions balance;
        balance.max_radius_edge = options_.max_radius_edge;
        balance.ends = field_->flat_ends();
        balance.slices = slices.sides;
        balance.end_tolerance_mm = interface_tolerance * stats.size_mm;
        const auto balanced_within = [&](double reach) {
            balance.max_offset_mm = reach * stats.size_mm;
            return balance_volumes({model_.mesh, neighbors_, *stars, fixed, model_.regions}, volumes_mm3_,
                                   balance, context_.threads);
        };
        BalanceStats balanced = balanced_within(balance_reach);
        if (balanced.worst_after > most_amiss) {
            const BalanceStats first = balanced;
            balanced = balanced_within(further_reach);
            balanced.moves += first.moves;
            balanced.largest_offset_mm += first.largest_offset_mm;
            balanced.worst_before = first.worst_before;
        }
        figures_ = improve_figures({improved, smoothed, dihedrals, routed_.size(), spurious, balanced});
        return end_stage("improve", 0.85);
    }

    // Re-routed contours are sound where the model will lie, or stay as they are drawn;
    // spurious components that they left go.
    SpuriousComponentStats settle_routed() {
        if (routed_.empty()) return {};
        const std::vector<std::uint32_t> vertices = vertices_of_contours();
        std::vector<Vec3> points = model_.mesh.points;
        move_back(points);
        for (std::size_t n = 0; n < vertices.size(); ++n) points[vertices[n]] = source_.points[n];
        drop_unsound(source_, routed_, points);
        return drop_spurious_components(kept_vertices(contours_, vertices, routed_, points.size()));
    }

    // The vertices of ill-shaped cells: the rest at such a vertex is as it is for what forces them, and the
    // worst of all would be what it may come to.
    void fix_ill_shaped(std::vector<std::uint8_t>& fixed) const {
        for (const std::uint32_t c : ill_shaped_cells(model_.mesh, context_.threads)) {
            for (const std::uint32_t v : model_.mesh.cells[c]) fixed[v] = 1;
        }
    }

    Status find_volumes() {
        if (volumes_.empty()) {
            ANATOMESH_TRY(volumes_, field_volumes(*field_, structures_, {}, context_));
        }
        for (const StructureVolume& volume : volumes_) volumes_mm3_.push_back(volume.by_field);
        return Nothing{};
    }

    VertexStars find_stars() const {
        return VertexStars(model_.mesh.cells, model_.mesh.points.size(), context_.threads);
    }

    SliceWeights slices_to_keep() const {
        return effort_.improvement.sections == SectionRepair::none ? SliceWeights{} : slices_;
    }

    // Where planes cross.
    CrossingPlanes crossing_planes() const { return {slices_.planes, slices_.extents, slices_.on_plane_mm}; }

    // No vertex of an interface passes through `slices`.
    SmoothStats smooth_all(const VertexStars& stars, const std::vector<std::uint8_t>& fixed,
                           const PlaneSides& slices, double max_mean = HUGE_VAL) {
        SmoothOptions options;
        options.slices = slices;
        options.max_mean = max_mean;
        options.max_radius_edge = options_.max_radius_edge;
        options.tolerance_mm = interface_tolerance * sample_->stats.size_mm;
        options.max_deviation_mm = surface_deviation * sample_->stats.size_mm;
        return smooth_vertices({model_.mesh, neighbors_, stars, fixed, model_.regions}, *field_, structures_,
                               options, context_);
    }

    // Contour segments that are edges of the surface stay edges of it.
    MeshImprovementStats improve_angles(std::vector<std::uint8_t>& fixed) {
        std::vector<Subsegment> subsegments = subsegment_list_;
        subsegments.insert(subsegments.end(), cut_subsegments_.begin(), cut_subsegments_.end());
        MeshImprovementOptions options;
        options.max_radius_edge = options_.max_radius_edge;
        options.tolerance_mm = interface_tolerance * sample_->stats.size_mm;
        options.max_deviation_mm = surface_deviation * sample_->stats.size_mm;
        options.spike_mm = spike_height * sample_->stats.size_mm;
        options.relabels_for_ratio = effort_.improvement.relabels_for_ratio;
        if (effort_.reduced) {
            options.target_degrees = dense_target_degrees;
            options.passes = 1;
            options.ratio_passes = 0;
            options.last_deviation = 1;  // the one pass is the last
        }
        const std::vector<std::uint32_t> slice_of = slices_of_vertices(
            contours_, vertices_of_contours(), subsegment_list_, model_.mesh.points.size());
        const ContourOwners owners = contour_owners(subsegments, model_.mesh.points.size());
        const std::vector<SubsegmentSides> sides =
            subsegment_sides(model_.mesh.cells, model_.mesh.regions, model_.regions,
                             model_.mesh.points.size(), subsegments, context_.threads);
        std::vector<std::array<std::uint32_t, 3>> beside;
        for (std::size_t n = 0; n < subsegments.size(); ++n) {
            if (sides[n].inside != sides[n].outside)
                beside.push_back({subsegments[n].a, subsegments[n].b, subsegments[n].structure});
        }
        const ImprovementEffort& effort = effort_.improvement;
        if (static_cast<double>(beside.size()) >
            effort.most_off_surface * static_cast<double>(subsegments.size()))
            beside.clear();
        std::vector<std::uint8_t> constraint_limited;
        if (!effort_.reduced || !beside.empty())
            constraint_limited = constraint_limited_vertices_of(subsegments);
        const bool worst_alone = effort.sections == SectionRepair::worst_at_last;
        const SliceWeights slices = slices_to_keep();
        const std::vector<std::uint32_t> contour_vertices = vertices_of_contours();
        std::vector<Plane> planes;
        for (const Slice& slice : contours_.slices) planes.push_back(slice.plane);
        const RoutableContours routable{contours_.contours, contour_vertices, planes, contours_.exclusive,
                                        most_reroute_mm(effort.most_rerouted_sizes)};
        if (effort.closes_handles) options.handle_mm = spurious_handle_reach * sample_->stats.size_mm;
        const std::vector<VertexPair> fixed_edges =
            edges_along(model_.mesh, neighbors_, segment_ends(contours_, vertices_of_contours()));
        return improve_mesh(
            model_.mesh, neighbors_, {fixed, fixed_edges}, *field_, structures_,
            {&model_.regions, slice_of, &owners, slices.planes, slices.extents, slices.weights,
             slices.on_plane_mm, worst_alone ? contract::section_tolerance : 0.0, beside, constraint_limited,
             routable},
            options, context_);
    }

    // By vertex; those of contours and of subsegments of their segments are looked at.
    std::vector<std::uint8_t> constraint_limited_vertices_of(
        const std::vector<Subsegment>& subsegments) const {
        std::vector<std::uint32_t> vertices = vertices_of_contours();
        for (const Subsegment& subsegment : subsegments)
            vertices.insert(vertices.end(), {subsegment.a, subsegment.b});
        sort_distinct(vertices, model_.mesh.points.size());
        return constraint_limited_vertices(model_.mesh, contours_, vertices_of_contours(), vertices,
                                           contract::forcing_share);
    }

    void drop_outside_cells() {
        TetMesh& mesh = model_.mesh;
        const std::vector<std::uint32_t> vertex = drop_outside(mesh, neighbors_, context_.threads);
        std::vector<std::uint32_t> contour_vertices = vertices_of_contours();
        for (std::uint32_t& v : contour_vertices) v = vertex[v];
        // With a vertex that was lost, a contour stays as it is drawn.
        std::erase_if(routed_, [&](RoutedContour& routed) {
            for (std::uint32_t& v : routed.vertices) v = vertex[v];
            return std::find(routed.vertices.begin(), routed.vertices.end(), no_cell) !=
                   routed.vertices.end();
        });
        compact_regions(mesh, model_.regions);
        move_back(mesh.points);
        // Contour vertices keep the coordinates that they came with, bit for bit.
        for (std::size_t n = 0; n < contour_vertices.size(); ++n) {
            const std::uint32_t v = contour_vertices[n];
            if (v != no_cell)
                mesh.points[v] = source_.points[n];  // one that was lost is the certificate's to find
        }
        snap_round_beside(contour_vertices);
        ContoursOfMesh kept = route_contours(source_, contour_vertices, routed_, mesh.points);
        model_.contours = std::move(kept.contours);
        model_.contour_vertices = std::move(kept.vertices);
        report().routed_contours = routed_contour_reports(source_, contour_vertices, routed_, mesh.points);
        model_.routed = std::move(routed_);
        model_.structures = contours_.structures;
        model_.field = known_field_;
        model_.field_origin = origin_;
    }

    // Where all that was done left segments that are no edges of the surface.
    void snap_round_beside(const std::vector<std::uint32_t>& contour_vertices) {
        const double most_mm = most_reroute_mm(effort_.improvement.most_snapped_sizes);
        if (segments_missed_ == 0 || !(most_mm > 0)) return;
        const std::vector<RoutedContour> before = routed_;
        routed_ = snap_round_segments(model_.mesh, neighbors_, model_.regions, source_, contour_vertices,
                                      std::move(routed_), {most_mm, context_.threads});
        has_segments_beside_ = routed_ != before;
    }

    double most_reroute_mm(double most_sizes) const {
        return std::min(options_.max_reroute_mm, most_sizes * sample_->stats.size_mm);
    }

    void move_back(std::vector<Vec3>& points) const {
        for (Vec3& p : points) p = p + origin_;
    }

    Status certify() {
        CertificateInput input{model_.mesh, model_.regions, model_.structures};
        input.contours = &source_;
        if (!model_.routed.empty()) input.on_surface = &model_.contours;
        input.field_volumes_mm3 = volumes_mm3_;
        input.field = field_.get();
        input.field_origin = origin_;
        measure_model(input, context_, report());
        ANATOMESH_CHECK_STATUS(end_stage("certificate", 1.0));
        warn_of_model(report(), sample_->stats.size_mm, contours_.source, context_);
        warn_of_overlaps(model_.mesh, model_.regions, model_.structures, contours_.source, context_);
        // Alone, a structure that tapers fast has another volume than its areas tell, and rightly.
        if (contours_.exclusive) warn_of_volumes(volumes_, model_.structures, contours_.source, context_);
        look_for_tears();
        // What was not done for their sake is the user's to know.
        if (effort_.reduced) warn_of_constraint_limited_cells(report(), contours_.source, context_);
        for (const Clause& clause : report().certificate) {
            if (clause.state != ClauseState::broken) continue;
            // Cuts, quality and volume are out of reach for this input; a wrong surface would be a fault of
            // ours.
            const bool out_of_reach = clause.number == 2 || clause.number == 4 || clause.number == 6;
            return Error{
                out_of_reach ? ErrorKind::geometry : ErrorKind::internal,
                "E-PIP-002",
                "clause " + std::to_string(clause.number) +
                    " of the certificate is broken: " + clause.statement + " (" + clause.evidence + ")",
                {},
                advice_on_size(mean_thickness(contours_), sample_->stats.size_mm, request_.size_given) +
                    "; nothing was written"};
        }
        return Nothing{};
    }

    // Clauses 1 to 6 hold for a plate with holes as well.
    void look_for_tears() {
        std::vector<std::size_t> same(structures_);
        std::iota(same.begin(), same.end(), std::size_t{0});
        const double size_mm = sample_->stats.size_mm;
        tears_ = check_topology({model_.mesh, neighbors_, model_.regions, report().structures,
                                 model_.contours, same, model_.contour_vertices, size_mm},
                                context_.threads);
        warn_of_topology(tears_, model_.contours, size_mm, context_);
    }

    ModelReport& report() { return model_.report; }
    const SliceArrangement& arrangement() const { return facts_->arrangement; }

    void end_stage_timing(const std::string& name) {
        const auto now = Clock::now();
        StageReport stage;
        stage.name = name;
        stage.seconds = std::chrono::duration<double>(now - stage_start_).count();
        stage.points = mesh_
                           ? (model_.mesh.points.empty() ? mesh_->points().size() : model_.mesh.points.size())
                           : (sample_ ? sample_->points.size() : 0);
        stage.cells =
            model_.mesh.cells.empty() ? (mesh_ ? mesh_->regions().size() : 0) : model_.mesh.cells.size();
        stage.figures = std::move(figures_);
        figures_.clear();
        report().stages.push_back(std::move(stage));
        stage_start_ = now;
    }

    // Notes the stage in the report, shows its mesh, and stops if the user wants it.
    Status end_stage(const std::string& name, double share_done) {
        end_stage_timing(name);
        if (observer_ && mesh_) {
            show(name);
            stage_start_ = Clock::now();
        }
        context_.report(name, share_done);
        if (context_.cancelled()) return cancelled_error();
        return Nothing{};
    }

    void show(const std::string& name) const {
        if (name == "certificate") return observer_(name, model_.mesh);
        TetMesh mesh = model_.mesh;
        if (mesh.cells.empty()) mesh = {mesh_->points(), mesh_->cells().cells, mesh_->regions()};
        if (mesh.regions.empty()) return;
        move_back(mesh.points);
        observer_(name, mesh);
    }

    const ContourSet& source_;  // as given
    const Vec3 origin_;
    const ContourSet contours_;  // relative to it
    const ModelOptions& options_;
    const EffortRequest request_;
    const double target_mean_ratio_;
    RunContext& context_;
    const StageObserver& observer_;
    std::uint32_t structures_;

    const std::shared_ptr<const SliceFacts> facts_;              // of the contours
    std::shared_ptr<const StructureField> known_field_, field_;  // the one, and as the stages ask it
    std::shared_ptr<const CountedField> counted_field_;          // the latter, on one thread
    std::vector<StructureVolume> volumes_;                       // of the field, by structure
    std::vector<double> volumes_mm3_;                            // by field
    std::size_t warnings_of_field_ = 0;                          // and before
    std::optional<PointSample> sample_;
    std::optional<LabelledMesh> mesh_;
    std::vector<std::array<std::uint32_t, 2>> owner_pairs_;
    std::optional<ContourSubsegments> subsegments_;  // of contour segments, in mesh_
    std::optional<RefinementRounds> refinement_;     // of mesh_
    Effort effort_;
    std::vector<Subsegment> subsegment_list_;  // those of subsegments_, and where the cut split them further
    std::vector<Subsegment> cut_subsegments_;  // of those that the last step of the cut split
    std::vector<RoutedContour> routed_;        // by contour
    std::uint64_t segments_missed_ = 0;        // before that
    bool has_segments_beside_ = false;         // over edges beside them
    std::uint64_t edited_cells_ = 0;           // made by improvement
    bool recovered_ = false;                   // some of them, by exchanging cells
    std::vector<std::uint8_t> given_;          // by vertex: one of a contour
    std::vector<std::uint32_t> neighbors_;     // of the cells of model_, from the cut on
    // Where subsegments were split after sampling, by the cut too.
    std::vector<std::uint32_t> segment_vertices_;
    SliceWeights slices_;
    std::vector<ContradictedPlace> contradicted_;  // where sections are fitted
    Model model_;
    TopologyFindings tears_;
    std::vector<std::pair<std::string, double>> figures_;  // of the stage under way
    Clock::time_point stage_start_ = Clock::now();
};

}  // namespace

BuiltOnce build_once(const ContourSet& contours, const RunConfig& config, RunContext& context,
                     const StageObserver& observer, FieldAndVolumes known) {
    Builder builder(contours, config, context, observer, std::move(known));
    Result<Model> model = builder.run();
    const RunScore score = builder.score(model);
    return {std::move(model), score, builder.field_and_volumes(), builder.size_mm(), builder.work()};
}

}  // namespace anatomesh
