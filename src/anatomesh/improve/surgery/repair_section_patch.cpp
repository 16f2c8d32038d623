#include "anatomesh/improve/surgery/repair_section_patch.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/core/surface_count.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/sections/cross_section_errors.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/relabel_membrane_neighborhood.h"
#include "anatomesh/improve/surgery/section_patches.h"
#include "anatomesh/improve/surgery/structure_components.h"

namespace anatomesh {

namespace {

constexpr double worth_a_patch = 5e-5;              // share of what is drawn that is wrong
constexpr double enough_less = 0.5;                 // of a patch
constexpr std::size_t most_cuts = 60;               // where more are wrong, slices contradict each other
constexpr std::size_t most_repaired_in_vain = 100;  // ways to repair whose cells are worked on in vain
// Cells worked on where planes cross, of one cut and of all: much more would be in vain.
constexpr std::size_t most_cells_of_cut = 5'000, most_cells_across = 20'000;
constexpr std::size_t most_tried = 1000;       // ways, sound or not
constexpr std::size_t most_of_component = 64;  // cells, as in spurious_components.h
constexpr std::array nearness{0.25, 0.0};      // of a vertex that is taken for one of the patch, in edges
// Of a membrane, as shares of the edges that lead off it; the last one not where planes cross, for there all
// cuts together have only so many tries.
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
          components_(edit, *drawn.owners, most_of_component),
          incidence_(edit),
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
        shapes_.emplace(edit_, drawn_, least_sine_);
        for (const std::size_t cut : cuts) repair_section(cut);
        return std::move(stats_);
    }

  private:
    // How a patch is repaired: the share of edges within which a vertex is taken for one of the patch, and as
    // relabel_membrane_neighborhood() has it.
    struct Way {
        double near;
        MembraneReach reach;
        double thickness;
    };

    enum class Outcome { done, unsound, bad };

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

    // Whether the patch is of the structure; it goes to the other side.
    bool is_inside(const SectionPatch& patch) const {
        return edit_.table->contains(patch.own, patch.structure);
    }

    // Where the structure is not parted a handle went, or a tunnel. What came off and no contour has goes
    // too, if it is small, near the field's surface and of no other region; false where more came off than
    // may.
    bool may_be_parted(const SectionPatch& patch, bool may_part, std::uint32_t first_new,
                       std::vector<std::uint32_t>& changed, std::uint64_t& spurious) {
        ComponentChange parts = components_.change(patch.structure, is_inside(patch), first_new);
        for (const std::vector<std::uint32_t>& component : parts.spurious) {
            if (parts.bare <= 0) break;
            if (!relabel_component(component, patch)) return false;
            changed.insert(changed.end(), component.begin(), component.end());
            ++spurious;
            --parts.bare;
            --parts.all;
        }
        return parts.bare <= 0 && (parts.all <= 0 || may_part);
    }

    // Whether two parts of where it goes, apart before, are one by it: else it made a handle or a tunnel.
    bool joins_parts(const SectionPatch& patch, std::uint32_t first_new) {
        return components_.change(patch.structure, !is_inside(patch), first_new).all == -1;
    }

    bool relabel_component(const std::vector<std::uint32_t>& component, const SectionPatch& patch) {
        const double most = edit_.options.spike_mm;
        edit_.look_between(patch.own, patch.to);
        for (const std::uint32_t c : component) {
            if (edit_.mesh.region(c) != patch.own) return false;
            for (const std::uint32_t v : edit_.mesh.cell(c)) {
                if (edit_.probe.distance(edit_.mesh.point(v), most) > most) return false;
            }
        }
        SurfaceCount count(edit_, *drawn_.owners, component, patch.to);
        for (const std::uint32_t c : component) edit_.mesh.set_region(c, patch.to);
        return count.figures().excess == 0 && count.newly_lost() == 0;
    }

    bool is_enough() const {
        return context_.cancelled() || improved_ >= most_repaired_in_vain || tried_ >= most_tried ||
               (!drawn_.extents.empty() &&
                (worked_on_ >= most_cells_across || worked_on_ - before_cut_ >= most_cells_of_cut));
    }

    bool repair_patch(const SectionPatch& patch, std::size_t cut, bool may_part) {
        const std::size_t count = repaired_thicknesses.size() - (drawn_.extents.empty() ? 0 : 1);
        farthest_mm_ = farthest_round(patch);
        for (const double near : nearness) {
            for (const MembraneReach reach : repaired_reaches) {
                for (const double thickness : std::span(repaired_thicknesses).first(count)) {
                    const Outcome outcome = attempt(patch, cut, {near, reach, thickness}, may_part);
                    ++tried_;
                    if (outcome == Outcome::done) return true;
                    improved_ += outcome == Outcome::bad;
                    if (is_enough()) return false;
                    if (outcome == Outcome::unsound) break;
                }
            }
        }
        return false;
    }

    Outcome attempt(const SectionPatch& patch, std::size_t cut, const Way& way, bool may_part) {
        const MeshImprovementStats stats = edit_.stats;
        edit_.mesh.begin_attempt();
        const Outcome outcome = change(patch, cut, way, may_part);
        edit_.mesh.end_attempt(outcome == Outcome::done);
        if (outcome != Outcome::done) edit_.stats = stats;
        return outcome;
    }

    Outcome change(const SectionPatch& patch, std::size_t cut, const Way& way, bool may_part) {
        std::uint64_t spurious = 0;
        const auto first_new = static_cast<std::uint32_t>(edit_.mesh.point_count());
        const Membrane membrane = membrane_of_patch(edit_, areas_, patch, way.near);
        const std::optional<std::uint32_t> end = vertex_on_surface(membrane, patch.structure);
        if (!end) return Outcome::unsound;
        const Chain chain{{*end}, patch.structure};
        const MembraneAcross across{MembraneSides::both, areas_.plane(patch.plane).normal, patch.to};
        std::optional<RelabelledNeighborhood> made = relabel_membrane_neighborhood(
            edit_, *drawn_.owners, chain, membrane, patch.own, way.reach, way.thickness, nullptr, &across);
        if (!made) return Outcome::unsound;
        std::vector<std::uint32_t> changed = std::move(made->changed);
        if (!made->parted.empty() && !may_be_parted(patch, may_part, first_new, changed, spurious))
            return Outcome::unsound;
        if (made->joins && (!may_part || !joins_parts(patch, first_new))) return Outcome::unsound;
        // Those round the edges that pass through the patch too.
        for (auto v = first_new; v < edit_.mesh.point_count(); ++v) {
            edit_.mesh.star(v, edit_.star);
            changed.insert(changed.end(), edit_.star.begin(), edit_.star.end());
        }
        sort_distinct(changed);
        const std::vector<std::uint32_t> improved = improve_(changed);
        changed.insert(changed.end(), improved.begin(), improved.end());
        sort_distinct(changed);
        worked_on_ += changed.size();
        if (!shapes_->allow(changed, farthest_mm_)) return Outcome::bad;
        if (!lessens(patch, cut)) return Outcome::bad;
        stats_.spurious_components_removed += spurious;
        shapes_->keep();
        errors_->keep();
        stats_.changed.insert(stats_.changed.end(), changed.begin(), changed.end());
        return Outcome::done;
    }

    // Whether the cut loses enough of what is wrong in the patch, and no other one gains as much and comes
    // near to what it may have.
    bool lessens(const SectionPatch& patch, std::size_t cut) {
        const double gained = enough_less * patch.wrong;
        const std::span<const double> before = errors_->sums(),
                                      after = errors_->sums_after(edit_.mesh.changed_cells());
        for (std::size_t other = 0; other < after.size(); ++other) {
            const double most = other == cut
                                    ? before[cut] - gained
                                    : std::max(before[other], std::min(before[other] + gained, much_of_cut));
            if (after[other] > most) return false;
        }
        return true;
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
        return shapes_->farthest_of(cells);
    }

    // One of the membrane's, of a contour if there is one.
    std::optional<std::uint32_t> vertex_on_surface(const Membrane& membrane, std::uint32_t structure) {
        std::optional<std::uint32_t> found;
        for (const std::uint32_t v : membrane.vertices()) {
            if (!incidence_.on_surface(v, structure)) continue;
            if (drawn_.owners->has(v, structure)) return v;
            if (!found) found = v;
        }
        return found;
    }

    EditContext& edit_;
    const RunContext& context_;
    const DrawnSlices& drawn_;
    SectionAreas areas_;
    StructureComponents components_;
    SurfaceIncidence incidence_;
    double least_sine_;
    const ImproveCells& improve_;
    std::optional<CrossSectionErrors> errors_;
    std::optional<QualityBudget> shapes_;
    double farthest_mm_ = 0;                      // from the field's, that surfaces of this patch may be
    std::size_t improved_ = 0, tried_ = 0;        // ways, the first in vain
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
