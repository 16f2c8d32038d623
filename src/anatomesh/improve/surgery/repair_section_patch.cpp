#include "anatomesh/improve/surgery/repair_section_patch.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/sections/cross_section_errors.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/membrane_surgery.h"
#include "anatomesh/improve/surgery/section_patches.h"

namespace anatomesh {

namespace {

// Share of what is drawn: a patch of which less is wrong stays. [1; 0 to 0.001; M 2026-11 random solids]
constexpr double worth_a_patch = 5e-5;
// Share of what is wrong in a patch that its repair must remove. [1; 0 to 1; M 2026-11 random solids]
constexpr double least_gain = 0.5;
constexpr std::size_t most_cuts =
    60;  // where more are wrong, slices contradict each other [sections; > 0; B]
constexpr std::size_t most_repaired_in_vain = 100;  // attempts whose cells are improved [attempts; > 0; B]
// Cells improved where planes cross, of one section and of all. [cells; > 0; B]
constexpr std::size_t most_cells_of_cut = 5'000;
// The same of all sections together. [cells; > 0; B]
constexpr std::size_t most_cells_across = 20'000;
constexpr std::size_t most_tried = 1000;  // attempts, sound or not [attempts; > 0; B]
// Share of an edge that passes through the patch: an end as near to the plane is a corner of it.
// [1; 0 to 0.5; M 2026-11, set not recorded]
constexpr std::array nearness{0.25, 0.0};
// Thicknesses of a membrane, as shares of the edges that lead off it. The last one is not tried where planes
// cross, because all sections together have only so many attempts there. [1; 0 to 1; M 2026-11, set not
// recorded]
constexpr std::array repaired_thicknesses{0.5, 0.3, 0.15, 0.7};

constexpr std::array repaired_reaches{MembraneReach::wide, MembraneReach::joined, MembraneReach::near,
                                      MembraneReach::others};

class SectionPatchRepair {
  public:
    SectionPatchRepair(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                       const ImproveCells& improve, const RunContext& context)
        : edit_(edit),
          context_(context),
          drawn_(drawn),
          areas_(edit, drawn),
          least_sine_(least_sine),
          improve_(improve) {}

    PatchRepairStats run(const std::vector<std::uint32_t>* look) {
        if (!look) {
            errors_.emplace(edit_, areas_, edit_.mesh.alive_cells(), context_.threads);
        } else if (!find_errors_from(*look)) {
            return {};
        }
        const std::span<const double> sums = errors_->sums();
        std::vector<std::size_t> cuts;
        for (std::size_t cut = 0; cut < sums.size(); ++cut) {
            if (sums[cut] > much_of_cut) cuts.push_back(cut);
        }
        if (cuts.size() > most_cuts) return {};
        std::stable_sort(cuts.begin(), cuts.end(),
                         [&](std::size_t a, std::size_t b) { return sums[a] > sums[b]; });
        surgery_.emplace(edit_, drawn_, &areas_, least_sine_, improve_);
        for (const std::size_t cut : cuts) repair_section(cut);
        return std::move(stats_);
    }

  private:
    // Of these cells and those round them at first, then, if a cut is not fine, of all; false if all are.
    bool find_errors_from(std::vector<std::uint32_t> cells) {
        std::erase_if(cells, [&](std::uint32_t c) { return !edit_.mesh.alive(c); });
        cells = areas_.cells_round(cells);
        errors_.emplace(edit_, areas_, cells, context_.threads);
        const std::span<const double> sums = errors_->sums();
        if (std::all_of(sums.begin(), sums.end(), [](double sum) { return sum <= much_of_cut; }))
            return false;
        errors_->add_others(cells, context_.threads);
        return true;
    }

    // First what leaves the structure in one part.
    void repair_section(std::size_t cut) {
        before_cut_ = worked_on_;
        while (errors_->sums()[cut] > much_of_cut && repair_one(cut, false)) {
        }
        while (errors_->sums()[cut] > most_of_cut && repair_one(cut, true)) {
        }
    }

    // One patch: that changes the cells of others.
    bool repair_one(std::size_t cut, bool may_part) {
        const auto structure = static_cast<std::uint32_t>(cut / drawn_.planes.size()),
                   plane = static_cast<std::uint32_t>(cut % drawn_.planes.size());
        for (const SectionPatch& patch : find_patches(edit_, areas_, structure, plane, context_.threads)) {
            if (patch.wrong < worth_a_patch || is_enough()) break;
            ++stats_.patches_found;
            if (!repair_patch(patch, cut, may_part)) continue;
            ++stats_.patches_repaired;
            return true;
        }
        return false;
    }

    bool is_enough() const {
        return context_.cancelled() || improved_ >= most_repaired_in_vain || tried_ >= most_tried ||
               (!drawn_.extents.empty() &&
                (worked_on_ >= most_cells_across || worked_on_ - before_cut_ >= most_cells_of_cut));
    }

    bool repair_patch(const SectionPatch& patch, std::size_t cut, bool may_part) {
        const std::size_t count = repaired_thicknesses.size() - (drawn_.extents.empty() ? 0 : 1);
        SurgeryProposal proposal;
        proposal.patch = &patch;
        proposal.relabelling.chain.structure = patch.structure;
        proposal.relabelling.own = patch.own;
        proposal.relabelling.across =
            MembraneAcross{MembraneSides::both, areas_.plane(patch.plane).normal, patch.to};
        proposal.topology = may_part ? TopologyChange::patch_in_parts : TopologyChange::patch_in_one_part;
        proposal.section = SectionGain{&*errors_, cut, least_gain * patch.wrong};
        proposal.most_mm = farthest_round(patch);
        for (const double near : nearness) {
            proposal.near = near;
            if (surgery_->attempt_each(proposal, repaired_reaches,
                                       std::span(repaired_thicknesses).first(count),
                                       [&](const SurgeryResult& result) { return note(result); }))
                return true;
            if (is_enough()) return false;
        }
        return false;
    }

    bool note(const SurgeryResult& result) {
        ++tried_;
        worked_on_ += result.changed.size();
        improved_ += result.verdict == SurgeryVerdict::in_vain;
        if (result.verdict == SurgeryVerdict::done) {
            stats_.spurious_components_removed += result.spurious_components_removed;
            stats_.changed.insert(stats_.changed.end(), result.changed.begin(), result.changed.end());
        }
        return !is_enough();
    }

    // How far from the field's surfaces lie about the patch now: what is wrong there may be far off.
    double farthest_round(const SectionPatch& patch) {
        std::vector<std::uint32_t> vertices, cells;
        for (const SectionAreas::Section& section : patch.sections) {
            const Cell& cell = edit_.mesh.cell(section.cell);
            vertices.insert(vertices.end(), cell.begin(), cell.end());
        }
        sort_distinct(vertices);
        for (const std::uint32_t v : vertices) {
            edit_.mesh.star(v, edit_.star);
            cells.insert(cells.end(), edit_.star.begin(), edit_.star.end());
        }
        sort_distinct(cells);
        return QualityGate(edit_, drawn_, least_sine_).farthest_of(cells);
    }

    EditContext& edit_;
    const RunContext& context_;
    const DrawnSlices& drawn_;
    SectionAreas areas_;
    double least_sine_;
    const ImproveCells& improve_;
    std::optional<CrossSectionErrors> errors_;
    std::optional<MembraneSurgery> surgery_;      // if a section is wrong
    std::size_t improved_ = 0, tried_ = 0;        // attempts, the first in vain
    std::size_t worked_on_ = 0, before_cut_ = 0;  // cells; those before this cut
    PatchRepairStats stats_;
};

}  // namespace

PatchRepairStats repair_section_patch(EditContext& edit, const DrawnSlices& drawn, double least_sine,
                                      const ImproveCells& improve, const RunContext& context,
                                      const std::vector<std::uint32_t>* look) {
    if (!drawn.table || !drawn.owners || drawn.planes.empty()) return {};
    return SectionPatchRepair(edit, drawn, least_sine, improve, context).run(look);
}

}  // namespace anatomesh
