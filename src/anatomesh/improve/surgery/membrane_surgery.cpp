#include "anatomesh/improve/surgery/membrane_surgery.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/surface_count.h"

namespace anatomesh {

namespace {

// Share of what is drawn by which sections may get worse before cells are improved: a third of what the
// contract allows. [1; 0 to 0.001; D about a third of section_tolerance]
constexpr double most_worse_sections = 3e-4;
// A larger component is none that a change leaves over, as in spurious_components.h.
// [cells; > 0; D as most_cells of spurious_components.cpp]
constexpr std::size_t most_of_component = 64;

}  // namespace

MembraneSurgery::MembraneSurgery(EditContext& edit, const DrawnSlices& drawn, SectionAreas* areas,
                                 double least_sine, const ImproveCells& improve)
    : edit_(edit),
      drawn_(drawn),
      areas_(areas),
      improve_(improve),
      incidence_(edit),
      components_(edit, *drawn.owners, most_of_component),
      budget_(edit, drawn, least_sine) {}

SurgeryResult MembraneSurgery::attempt(const SurgeryProposal& proposal) {
    const MeshImprovementStats stats = edit_.stats;
    SurgeryResult result;
    edit_.mesh.begin_attempt();
    result.verdict = change(proposal, result);
    const bool done = result.verdict == SurgeryVerdict::done;
    edit_.mesh.end_attempt(done);
    if (done) {
        budget_.keep();
        if (proposal.section) proposal.section->errors->keep();
        return result;
    }
    edit_.stats = stats;
    if (result.verdict == SurgeryVerdict::in_vain) {
        keep(proposal.relabelling.chain);
    } else {
        result.changed.clear();
    }
    return result;
}

SurgeryVerdict MembraneSurgery::change(const SurgeryProposal& proposal, SurgeryResult& result) {
    const auto first_new = static_cast<std::uint32_t>(edit_.mesh.point_count());
    MembraneRelabelling relabelling = proposal.relabelling;
    if (proposal.patch && !cut_membrane(*proposal.patch, proposal.near, relabelling))
        return SurgeryVerdict::unsound;
    std::optional<RelabelledNeighborhood> made = relabel_membrane_neighborhood(
        edit_, *drawn_.owners, relabelling, proposal.section ? nullptr : areas_);
    if (!made) return SurgeryVerdict::unsound;
    result.changed = std::move(made->changed);
    result.parts_cells = made->parts_cells;
    if (!topology_may_become(proposal, *made, first_new, result)) return SurgeryVerdict::unsound;
    if (made->wrong_of_cuts > most_worse_sections) return SurgeryVerdict::spoils_sections;
    release(relabelling.chain);
    improve(first_new, result.changed);
    const bool may_stay = incidence_.on_surface(relabelling.chain.vertices, relabelling.chain.structure) &&
                          cells_may_stay(proposal, result) &&
                          (!proposal.section || section_gains(*proposal.section));
    return may_stay ? SurgeryVerdict::done : SurgeryVerdict::in_vain;
}

bool MembraneSurgery::cut_membrane(const SectionPatch& patch, double near, MembraneRelabelling& relabelling) {
    relabelling.membrane = membrane_of_patch(edit_, *areas_, patch, near);
    const std::optional<std::uint32_t> end = vertex_on_surface(relabelling.membrane, patch.structure);
    if (end) relabelling.chain = {{*end}, patch.structure};
    return end.has_value();
}

std::optional<std::uint32_t> MembraneSurgery::vertex_on_surface(const Membrane& membrane,
                                                                std::uint32_t structure) {
    std::vector<std::uint32_t> vertices = membrane.vertices();
    std::erase_if(vertices, [&](std::uint32_t v) { return !incidence_.on_surface(v, structure); });
    if (vertices.empty()) return std::nullopt;
    return contour_vertex_or_first(*drawn_.owners, vertices, structure);
}

bool MembraneSurgery::topology_may_become(const SurgeryProposal& proposal, const RelabelledNeighborhood& made,
                                          std::uint32_t first_new, SurgeryResult& result) {
    const std::uint32_t structure = proposal.relabelling.chain.structure;
    switch (proposal.topology) {
        case TopologyChange::unchanged:
            return true;
        case TopologyChange::handle_goes:
            return std::find(made.parted.begin(), made.parted.end(), structure) != made.parted.end() &&
                   std::all_of(made.parted.begin(), made.parted.end(),
                               [&](std::uint32_t s) { return keeps_components(s, first_new); });
        case TopologyChange::patch_in_one_part:
        case TopologyChange::patch_in_parts:
            break;
    }
    if (!made.parted.empty() && !remove_spurious_components(proposal, first_new, result)) return false;
    if (!made.joins) return true;
    // Two parts of the side where cells go are one now; else there is a new handle or tunnel.
    const bool inside = edit_.table->contains(proposal.relabelling.own, structure);
    return proposal.topology == TopologyChange::patch_in_parts &&
           components_.change(structure, !inside, first_new).all == -1;
}

bool MembraneSurgery::keeps_components(std::uint32_t structure, std::uint32_t first_new) {
    return components_.change(structure, true, first_new).all == 0 &&
           components_.change(structure, false, first_new).all == 0;
}

// Where the structure is not parted a handle went, or a tunnel. False where more came off than may.
bool MembraneSurgery::remove_spurious_components(const SurgeryProposal& proposal, std::uint32_t first_new,
                                                 SurgeryResult& result) {
    const std::uint32_t structure = proposal.relabelling.chain.structure;
    const bool inside = edit_.table->contains(proposal.relabelling.own, structure);
    ComponentChange parts = components_.change(structure, inside, first_new);
    for (const std::vector<std::uint32_t>& component : parts.spurious) {
        if (parts.bare <= 0) break;
        if (!relabel_component(component, proposal.relabelling)) return false;
        result.changed.insert(result.changed.end(), component.begin(), component.end());
        ++result.spurious_components_removed;
        --parts.bare;
        --parts.all;
    }
    return parts.bare <= 0 && (parts.all <= 0 || proposal.topology == TopologyChange::patch_in_parts);
}

bool MembraneSurgery::relabel_component(const std::vector<std::uint32_t>& component,
                                        const MembraneRelabelling& relabelling) {
    const Region own = relabelling.own, to = *relabelling.across->to;
    const double most = edit_.options.spike_mm;
    edit_.look_between(own, to);
    for (const std::uint32_t c : component) {
        if (edit_.mesh.region(c) != own) return false;
        for (const std::uint32_t v : edit_.mesh.cell(c)) {
            if (edit_.probe.distance(edit_.mesh.point(v), most) > most) return false;
        }
    }
    SurfaceCount count(edit_, *drawn_.owners, component, to);
    for (const std::uint32_t c : component) edit_.mesh.set_region(c, to);
    return count.figures().excess == 0 && count.newly_lost() == 0;
}

// Cells at new vertices are those too that were made when the membrane was cut out of its patch.
void MembraneSurgery::improve(std::uint32_t first_new, std::vector<std::uint32_t>& changed) {
    for (auto v = first_new; v < edit_.mesh.point_count(); ++v) {
        edit_.mesh.star(v, edit_.star);
        changed.insert(changed.end(), edit_.star.begin(), edit_.star.end());
    }
    sort_distinct(changed);
    const std::vector<std::uint32_t> improved = improve_(changed);
    changed.insert(changed.end(), improved.begin(), improved.end());
    sort_distinct(changed);
}

bool MembraneSurgery::cells_may_stay(const SurgeryProposal& proposal, SurgeryResult& result) {
    result.more_above = budget_.growth(result.changed, proposal.most_mm);
    if (!result.more_above) return false;
    if (!proposal.most_more_where_parted) return *result.more_above <= budget_.allowance();
    return !result.parts_cells || *result.more_above <= *proposal.most_more_where_parted;
}

bool MembraneSurgery::section_gains(const SectionGain& gain) const {
    const std::span<const double> before = gain.errors->sums(),
                                  after = gain.errors->sums_after(edit_.mesh.changed_cells());
    for (std::size_t other = 0; other < after.size(); ++other) {
        const double most = other == gain.cross_section
                                ? before[other] - gain.least
                                : std::max(before[other], std::min(before[other] + gain.least, much_of_cut));
        if (after[other] > most) return false;
    }
    return true;
}

void MembraneSurgery::release(const Chain& chain) {
    for (std::size_t n = 1; n < chain.vertices.size(); ++n) {
        edit_.constraints.fix_edge(chain.vertices[n - 1], chain.vertices[n]);
        edit_.constraints.release_edge(chain.vertices[n - 1], chain.vertices[n]);
    }
}

void MembraneSurgery::keep(const Chain& chain) {
    for (std::size_t n = 1; n < chain.vertices.size(); ++n)
        edit_.constraints.keep_edge(chain.vertices[n - 1], chain.vertices[n]);
}

std::uint32_t contour_vertex_or_first(const ContourOwners& owners, std::span<const std::uint32_t> vertices,
                                      std::uint32_t structure) {
    const auto found = std::find_if(vertices.begin(), vertices.end(),
                                    [&](std::uint32_t v) { return owners.has(v, structure); });
    return found == vertices.end() ? vertices.front() : *found;
}

}  // namespace anatomesh
