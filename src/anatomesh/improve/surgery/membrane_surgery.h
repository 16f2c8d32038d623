// MembraneSurgery: a change of a surface over a membrane, as a transaction: it is made, checked, and kept or
// undone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/sections/cross_section_errors.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/relabel_membrane_neighborhood.h"
#include "anatomesh/improve/surgery/section_patches.h"
#include "anatomesh/improve/surgery/structure_components.h"

namespace anatomesh {

// What may become of the topology of structures, beside what relabel_membrane_neighborhood() refuses.
// - `unchanged`: no characteristic changes.
// - `handle_goes`: the membrane's structure loses a handle or a tunnel. It and all others that lose one keep
//   the number of their components, and so does what is outside of each.
// - `patch_in_one_part`: the structure may lose a handle or a tunnel. What comes off and no contour has goes
//   too, if it is small, near the field's surface and of no other region.
// - `patch_in_parts`: the structure may also fall into parts, each with a vertex of a contour of its, or two
//   parts of the side where cells go may be joined.
enum class TopologyChange { unchanged, handle_goes, patch_in_one_part, patch_in_parts };

// A cross-section that must lose so much of what is wrong in it, while no other one gains as much and comes
// near to what it may have.
struct SectionGain {
    CrossSectionErrors* errors = nullptr;  // of all cells; kept up to date if the change stays
    std::size_t cross_section = 0;         // structure * planes + slice
    double least = 0;                      // share of what is drawn
};

struct SurgeryProposal {
    MembraneRelabelling relabelling;
    // If any, the membrane is cut out of this patch first, and the chain is a vertex of it on the surface.
    const SectionPatch* patch = nullptr;
    double near = 0;  // as membrane_of_patch() has it
    TopologyChange topology = TopologyChange::unchanged;
    // Without one, sections may get worse by no more than 3e-4 of what is drawn before cells are improved.
    std::optional<SectionGain> section;
    double most_mm = 0;  // interfaces of changed cells may be so far from the field's
    // By how many the cells above the edit context's first bound may grow where cells of the chain's region
    // are parted; elsewhere by any number. Without one: as QualityBudget allows.
    std::optional<std::size_t> most_more_where_parted;
};

enum class SurgeryVerdict {
    done,
    unsound,          // a cell, a surface, a contour or the topology would not be as it must be
    spoils_sections,  // before cells were improved
    in_vain           // after cells were improved
};

struct SurgeryResult {
    SurgeryVerdict verdict = SurgeryVerdict::unsound;
    std::vector<std::uint32_t> changed;  // cells, if they were improved; some may be gone
    std::uint64_t spurious_components_removed = 0;
    bool parts_cells = false;               // of the chain's region, at a vertex of the membrane
    std::optional<std::size_t> more_above;  // cells above the first bound; nothing where cells are not good
};

class MembraneSurgery {
  public:
    // `areas`: of the slices, or null where no sections are looked at. `least_sine`: of cells inside that
    // contours do not limit. Requires: all outlive this; `drawn` has table and owners. Complexity: O(cells)
    MembraneSurgery(EditContext& edit, const DrawnSlices& drawn, SectionAreas* areas, double least_sine,
                    const ImproveCells& improve);

    // Steps: cut the membrane out of its patch; relabel its neighbourhood; check the topology and the
    // sections; release the chain's subsegments, which are fixed from then on; improve the shapes of the
    // cells; check the chain, the cells and the section. If all is well the change stays, else the mesh and
    // the counters of the context are as before. A change keeps the fixed edges that it made in any case, and
    // one that is undone keeps the chain's subsegments again. Same result every time. Errors: none.
    SurgeryResult attempt(const SurgeryProposal& proposal);

    // Attempts each reach with each thickness, until one is done or `goes_on(result)` is false. Where a
    // thickness is unsound, the next reach follows at once. Returns whether one was done.
    template <class GoesOn>
    bool attempt_each(SurgeryProposal proposal, std::span<const MembraneReach> reaches,
                      std::span<const double> thicknesses, const GoesOn& goes_on) {
        for (const MembraneReach reach : reaches) {
            for (const double thickness : thicknesses) {
                proposal.relabelling.reach = reach;
                proposal.relabelling.thickness = thickness;
                const SurgeryResult result = attempt(proposal);
                const bool more = goes_on(result);
                if (result.verdict == SurgeryVerdict::done) return true;
                if (!more) return false;
                if (result.verdict == SurgeryVerdict::unsound) break;
            }
        }
        return false;
    }

    const QualityBudget& budget() const { return budget_; }

  private:
    SurgeryVerdict change(const SurgeryProposal& proposal, SurgeryResult& result);
    bool cut_membrane(const SectionPatch& patch, double near, MembraneRelabelling& relabelling);
    std::optional<std::uint32_t> vertex_on_surface(const Membrane& membrane, std::uint32_t structure);

    bool topology_may_become(const SurgeryProposal& proposal, const RelabelledNeighborhood& made,
                             std::uint32_t first_new, SurgeryResult& result);
    bool keeps_components(std::uint32_t structure, std::uint32_t first_new);
    bool remove_spurious_components(const SurgeryProposal& proposal, std::uint32_t first_new,
                                    SurgeryResult& result);
    bool relabel_component(const std::vector<std::uint32_t>& component,
                           const MembraneRelabelling& relabelling);

    void improve(std::uint32_t first_new, std::vector<std::uint32_t>& changed);
    bool cells_may_stay(const SurgeryProposal& proposal, SurgeryResult& result);
    bool section_gains(const SectionGain& gain) const;
    void release(const Chain& chain);
    void keep(const Chain& chain);

    EditContext& edit_;
    const DrawnSlices& drawn_;
    SectionAreas* areas_;
    const ImproveCells& improve_;
    SurfaceIncidence incidence_;
    StructureComponents components_;
    QualityBudget budget_;
};

// A vertex of these on the surface of a structure that a contour of it has, or else the first one.
std::uint32_t contour_vertex_or_first(const ContourOwners& owners, std::span<const std::uint32_t> vertices,
                                      std::uint32_t structure);

}  // namespace anatomesh
