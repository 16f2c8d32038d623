#include "anatomesh/improve/improve_mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/improve/climb/hill_climber.h"
#include "anatomesh/improve/reroute/reroute_on_section.h"
#include "anatomesh/improve/sections/detach_facets_from_plane.h"
#include "anatomesh/improve/sections/repair_section_locally.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/smooth/flip_surface_edges.h"
#include "anatomesh/improve/surgery/recover_on_surface.h"
#include "anatomesh/improve/surgery/remove_spikes.h"
#include "anatomesh/improve/surgery/remove_spurious_handles.h"
#include "anatomesh/improve/surgery/repair_section_patch.h"

namespace anatomesh {

namespace {

// Operations aim so far above the target, since later ones take a little. [degrees; >= 0; M 2026-11, set not
// recorded]
constexpr double margin_degrees = 3;
// At last a chain of subsegments may cost this share of the cells inside, above the bound of ratios.
// [1; 0 to 1; M 2026-11 fetal brain, body labels, skull mask]
constexpr double most_for_segment = 1e-5;
// One cell in so many may be above the last bound for these to be worked on: more are where planes crowd each
// other, and the cells in their place would spoil the rest.
// [cells; > 0; M 2026-11 pelvis, spine, skull, 61 labels, fetal brain]
constexpr std::size_t few_high = 2000;
// Blemishes are visited this many times their number at most. [1; >= 1; B]
constexpr std::size_t visits_per_blemish = 4;
// Flat cells between contours that are visited at most. [cells; > 0; B]
constexpr std::size_t most_flat = 1000;
// A kind of surgery visits so many cells at least, for shapes, and no more than these and a share of all cells together.
// [cells; >= 0; M 2026-12 the 8 slowest of 140 random solids, 9,000 of 60,000 cells; halves exchanged on a slice 64,000]
constexpr std::uint64_t least_visits_of_surgery = 8000;
// The same, as a share of the cells. [1; > 0; M 2026-12 the same]
constexpr double visits_of_surgery = 0.15;

void append(std::vector<std::uint32_t>& cells, const std::vector<std::uint32_t>& more) {
    cells.insert(cells.end(), more.begin(), more.end());
}

// What the steps hand on to each other.
struct ImprovementState {
    BadCellQueue bad;  // cells inside below the target
    std::vector<std::uint32_t>
        changed;  // cells that detachments and repairs changed since the queue was made
    std::vector<std::uint32_t> watched;    // from the last angles on: cells that may be bad in the end
    std::vector<std::uint32_t> at_planes;  // cells where local repairs left a section that is wrong
    double least_degrees = 0;              // surgeries at the end leave no smaller angle
};

// The steps of improve_mesh() and what all of them use. A step works on the mesh of the edit context and on
// the state.
class MeshImprovement {
  public:
    MeshImprovement(EditContext& edit, const DrawnSlices& drawn, const RunContext& context)
        : edit_(edit),
          context_(context),
          constraint_limited_(drawn.constraint_limited.begin(), drawn.constraint_limited.end()),
          drawn_(drawn),
          profiles_(edit.options),
          climber_(edit, context) {
        drawn_.constraint_limited = constraint_limited_;
        if (drawn.least_wrong > 0) {
            drawn_.planes = {};
            drawn_.extents = {};
            drawn_.weights = {};
            at_last_ = drawn;
            at_last_.constraint_limited = constraint_limited_;
        }
        edit.drawn = &drawn_;
        edit.goal = std::sin((edit.options.target_degrees + margin_degrees) * radians_per_degree);
    }

    void run() {
        for (const Step& step : steps) (this->*step)();
    }

  private:
    using Step = void (MeshImprovement::*)();
    static const std::array<Step, 25> steps;

    // Subsegments beside the surface stay edges, so that those which cannot be recovered at first may be when
    // the cells are better.
    void keep_subsegments() {
        for (const auto& [a, b, structure] : drawn_.subsegments_beside) edit_.constraints.keep_edge(a, b);
    }

    void remove_small_spikes() {
        edit_.stats.surgeries.cell_spikes_removed +=
            remove_cell_spikes(edit_, target_sine(edit_.options), context_.threads);
    }

    void remove_far_spikes() {
        edit_.stats.surgeries.spikes_removed +=
            remove_spikes(edit_, edit_.options.least_spike_mm, listed_sine(), context_.threads).removed;
    }

    void recover_subsegments_first() { recover_subsegments(listed_sine(), 0); }

    void find_bad_cells() {
        state_.bad =
            climber_.queue_of(profiles_[ClimbPass::angles], edit_.mesh.alive_cells(), context_.threads);
        edit_.stats.bad_before = state_.bad.size();
        edit_.stats.worst_before_degrees = worst_degrees(state_.bad);
    }

    void raise_angles() { climb(ClimbPass::angles); }

    // Edges of surfaces are flipped for smaller angles between facets; cells that are bad now are queued.
    void flip_edges() {
        std::vector<std::uint32_t> changed;
        FlipOptions options;
        options.good_sine = target_sine(edit_.options);
        options.least_gain_degrees = edit_.options.flip_gain_degrees;
        flip_surface_edges(edit_, options, context_.threads, changed);
        sort_distinct(changed, edit_.mesh.cell_count());
        BadCellQueue bad =
            climber_.queue_of(profiles_[ClimbPass::angles], std::move(changed), context_.threads);
        while (!bad.empty()) state_.bad.push(bad.take_worst());
    }

    // For the cells that are left the bound of deviation grows, for good: they may have more room.
    void raise_angles_with_more_room() {
        edit_.options.max_deviation_mm *= edit_.options.last_deviation;
        climb(ClimbPass::angles);
    }

    void detach_facets() {
        const DetachmentStats detached =
            detach_facets_from_plane(edit_, drawn_, listed_sine(), context_.threads);
        edit_.stats.sections.facets_detached = detached.facets_detached;
        edit_.stats.sections.facets_left = detached.facets_left;
        state_.changed = detached.changed;
    }

    // From here on junctions may move.
    void repair_sections() {
        edit_.rule.moves_junctions = true;
        LocalRepairStats repaired = repair_section_locally(edit_, drawn_, listed_sine(), context_, nullptr);
        count_repaired(repaired);
        append(state_.changed, repaired.changed);
        state_.at_planes = std::move(repaired.left);
    }

    // From here on few cells change: those and the bad ones are all that may be bad in the end. Sections are
    // guarded until a surgery has changed them.
    void raise_last_angles() {
        edit_.rule.guards_sections = true;
        std::vector<std::uint32_t> cells = std::move(state_.changed);
        append(cells, state_.bad.take_cells());
        state_.bad = climber_.queue_of(profiles_[ClimbPass::last_angles], std::move(cells), context_.threads);
        state_.watched = BadCellQueue(state_.bad).take_cells();
        climb(ClimbPass::last_angles);
    }

    void raise_listed_angles() {
        if (!(edit_.options.last_radius_edge > edit_.options.max_radius_edge)) return;
        for (const ClimbPass pass :
             {ClimbPass::listed_angles_1, ClimbPass::listed_angles_2, ClimbPass::listed_angles_3}) {
            state_.bad = climber_.queue_of(profiles_[pass], state_.bad.take_cells(), context_.threads);
            climb(pass);
        }
    }

    void lower_high_ratios() {
        if (!(edit_.options.last_radius_edge > edit_.options.max_radius_edge)) return;
        const ClimbProfile& profile = profiles_[ClimbPass::high_ratios];
        std::vector<std::uint32_t> cells = climber_.bad_cells(profile, context_.threads);
        if (cells.size() > edit_.mesh.cell_count() / few_high) return;
        climber_.climb_list(profile, std::move(cells), state_.watched);
    }

    void lower_ratios() {
        const ClimbProfile& profile = profiles_[ClimbPass::ratios];
        for (int pass = 0; pass < edit_.options.ratio_passes; ++pass) {
            std::vector<std::uint32_t> cells = climber_.bad_cells(profile, context_.threads);
            if (climber_.climb_list(profile, std::move(cells), state_.watched) == 0) break;
        }
    }

    // Single cells that are left ill-shaped beside those that contours force to be.
    void repair_blemishes() {
        if (drawn_.constraint_limited.empty()) return;
        const ClimbProfile& profile = profiles_[ClimbPass::blemishes];
        std::vector<std::uint32_t> cells = climber_.bad_cells(profile, context_.threads);
        const std::size_t most_visits = visits_per_blemish * cells.size();
        climber_.climb_list(profile, std::move(cells), state_.watched, most_visits);
    }

    // Where no cell has changed since the first repair there is nothing new.
    void repair_sections_again() {
        append(state_.at_planes, state_.watched);
        LocalRepairStats repaired =
            repair_section_locally(edit_, drawn_, listed_sine(), context_, &state_.at_planes);
        count_repaired(repaired);
        append(state_.watched, repaired.changed);
        state_.at_planes = std::move(repaired.left);
    }

    void find_least_angle() {
        const BadCellQueue bad =
            climber_.queue_of(profiles_[ClimbPass::angles], state_.watched, context_.threads);
        state_.bad = {};
        state_.least_degrees = std::max(worst_degrees(bad), contract::bad_dihedral_degrees);
    }

    // Subsegments that could not be recovered at first, for no angle below the least there is.
    void recover_subsegments_last() { recover_subsegments(least_sine(), most_for_segment); }

    // Handles of the mesh's own making.
    void remove_small_handles() {
        if (!(edit_.options.handle_mm > 0)) return;
        const HandleRemovalStats removed =
            remove_spurious_handles(edit_, drawn_at_last(), edit_.options.handle_mm, least_sine(),
                                    improvement_of_surgery(), context_);
        edit_.stats.surgeries.handles_found += removed.found;
        edit_.stats.surgeries.handles_removed += removed.removed;
        append(state_.watched, removed.changed);
    }

    // Sections of which more is wrong than may be, if sections are not looked at before.
    void repair_worst_sections() {
        if (at_last_.planes.empty()) return;
        SectionAreas areas(edit_, at_last_);
        areas.sum_cuts(edit_.mesh.alive_cells(), context_.threads);
        std::vector<double> weights(at_last_.weights.begin(), at_last_.weights.end());
        for (std::size_t cut = 0; cut < weights.size(); ++cut) {
            if (areas.sums()[cut] <= at_last_.least_wrong) weights[cut] = 0;
        }
        const std::span<const double> before = std::exchange(at_last_.weights, weights);
        const LocalRepairStats repaired = repair_section_locally(edit_, at_last_, listed_sine(), context_);
        count_repaired(repaired);
        append(state_.watched, repaired.changed);
        at_last_.weights = before;
    }

    // Sections that are wrong still, at the cells where local repairs looked at them. Subsegments that could
    // not be recovered would be in the way, so they are kept no longer.
    void repair_patches() {
        append(state_.at_planes, state_.watched);
        edit_.constraints.release_edges();
        const PatchRepairStats repaired =
            repair_section_patch(edit_, drawn_at_last(), least_sine(), improvement_of_surgery(), context_,
                                 at_last_.planes.empty() ? &state_.at_planes : nullptr);
        edit_.stats.sections.found += repaired.patches_found;
        edit_.stats.sections.repaired += repaired.patches_repaired;
        edit_.stats.surgeries.spurious_components_removed += repaired.spurious_components_removed;
        append(state_.watched, repaired.changed);
    }

    // Contours whose segments no edges of the surface run along after all.
    void reroute_contours() {
        RerouteStats stats = reroute_on_section(edit_, drawn_, constraint_limited_, least_sine(),
                                                listed_sine(), improvement_of_surgery(), context_);
        edit_.stats.segments_missed = stats.missed;
        edit_.stats.routed = std::move(stats.routed);
        append(state_.watched, stats.changed);
    }

    void repair_flat_cells() {
        if (drawn_.constraint_limited.empty()) return;
        const ClimbProfile& profile = profiles_[ClimbPass::flat_cells];
        climber_.climb_list(profile, climber_.bad_cells(profile, context_.threads), state_.watched,
                            most_flat);
    }

    void count_bad_cells() {
        state_.bad =
            climber_.queue_of(profiles_[ClimbPass::angles], std::move(state_.watched), context_.threads);
        edit_.stats.bad_after = state_.bad.size();
        edit_.stats.worst_after_degrees = worst_degrees(state_.bad);
    }

    void climb(ClimbPass pass) { climber_.climb(profiles_[pass], state_.bad, state_.watched); }

    void recover_subsegments(double least, double most_more_above_bound) {
        const SurfaceRecoveryStats recovered =
            recover_on_surface(edit_, drawn_, least, most_more_above_bound, improvement_of_surgery());
        edit_.stats.surgeries.subsegments_found =
            std::max(edit_.stats.surgeries.subsegments_found, recovered.found);
        edit_.stats.surgeries.subsegments_recovered += recovered.recovered;
        append(state_.watched, recovered.changed);
    }

    // What a surgery does for the shapes of its cells and of those that come of them. After so much of it, nothing: what
    // remains to be tried is in vain then, unless it is good at once.
    ImproveCells improvement_of_surgery() {
        const std::uint64_t last =
            climber_.visits() + least_visits_of_surgery +
            static_cast<std::uint64_t>(visits_of_surgery * static_cast<double>(edit_.mesh.cell_count()));
        return [this, last](std::vector<std::uint32_t> cells) {
            if (climber_.visits() >= last) {
                edit_.rule.moves_junctions = edit_.rule.guards_sections = false;
                return std::vector<std::uint32_t>{};
            }
            std::vector<std::uint32_t> changed =
                climber_.climb_from(profiles_[ClimbPass::surgery_angles], cells);
            append(cells, changed);
            const std::vector<std::uint32_t> more =
                climber_.climb_from(profiles_[ClimbPass::surgery_listed_angles], cells);
            append(changed, more);
            append(cells, more);
            sort_distinct(cells);
            climber_.climb_list(profiles_[ClimbPass::surgery_ratios], std::move(cells), changed);
            // From here on only the passes themselves move junctions and guard sections.
            edit_.rule.moves_junctions = edit_.rule.guards_sections = false;
            return changed;
        };
    }

    void count_repaired(const LocalRepairStats& repaired) {
        edit_.stats.sections.found += repaired.places_found;
        edit_.stats.sections.repaired += repaired.vertices_moved + repaired.cells_relabelled +
                                         repaired.edges_flipped + repaired.edges_collapsed +
                                         repaired.vertices_inserted;
    }

    double worst_degrees(const BadCellQueue& bad) const {
        return bad.empty() ? edit_.options.target_degrees
                           : std::asin(std::max(0.0, bad.worst().sine)) / radians_per_degree;
    }

    double least_sine() const { return std::sin(state_.least_degrees * radians_per_degree); }

    const DrawnSlices& drawn_at_last() const { return at_last_.planes.empty() ? drawn_ : at_last_; }

    EditContext& edit_;
    const RunContext& context_;
    std::vector<std::uint8_t> constraint_limited_;  // by vertex; contours that are re-routed free some
    DrawnSlices drawn_;
    DrawnSlices at_last_;  // if any: of sections that are looked at then alone
    ClimbProfiles profiles_;
    HillClimber climber_;
    ImprovementState state_;
};

const std::array<MeshImprovement::Step, 25> MeshImprovement::steps{
    &MeshImprovement::keep_subsegments,
    &MeshImprovement::remove_small_spikes,
    &MeshImprovement::remove_far_spikes,
    &MeshImprovement::recover_subsegments_first,
    &MeshImprovement::find_bad_cells,
    &MeshImprovement::raise_angles,
    &MeshImprovement::flip_edges,
    &MeshImprovement::raise_angles_with_more_room,
    &MeshImprovement::remove_small_spikes,
    &MeshImprovement::detach_facets,
    &MeshImprovement::repair_sections,
    &MeshImprovement::raise_last_angles,
    &MeshImprovement::raise_listed_angles,
    &MeshImprovement::lower_high_ratios,
    &MeshImprovement::lower_ratios,
    &MeshImprovement::repair_blemishes,
    &MeshImprovement::repair_sections_again,
    &MeshImprovement::find_least_angle,
    &MeshImprovement::recover_subsegments_last,
    &MeshImprovement::remove_small_handles,
    &MeshImprovement::repair_worst_sections,
    &MeshImprovement::repair_patches,
    &MeshImprovement::reroute_contours,
    &MeshImprovement::repair_flat_cells,
    &MeshImprovement::count_bad_cells,
};

}  // namespace

MeshImprovementStats improve_mesh(TetMesh& mesh, std::vector<std::uint32_t>& neighbors,
                                  const EditConstraints& constraints, const StructureField& field,
                                  std::uint32_t structures, const DrawnSlices& drawn,
                                  const MeshImprovementOptions& options, RunContext& context) {
    assert(constraints.vertex_count() == mesh.points.size());
    EditMesh edited(std::move(mesh), neighbors);
    EditContext edit(edited, constraints, field, structures, options);
    edit.table = drawn.table;
    MeshImprovement(edit, drawn, context).run();
    edit.stats.cells_made = edited.cells_made();
    mesh = std::move(edited).take(neighbors, context.threads);
    return edit.stats;
}

}  // namespace anatomesh
