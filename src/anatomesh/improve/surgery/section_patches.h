// find_patches, membrane_of_patch: what a cut by a slice's plane has too much or too little of a structure.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/sections/section_areas.h"
#include "anatomesh/improve/surgery/spanning_membranes.h"

namespace anatomesh {

// Sections beside each other, of one region, where the same is drawn.
struct SectionPatch {
    std::uint32_t structure = 0, plane = 0;
    Region own = 0, to = 0;  // theirs, and that of all that is drawn there
    std::vector<SectionAreas::Section> sections;
    double wrong = 0;  // share of what is drawn of the structure
};

// Of a cut those that a region of the mesh is drawn for, from which most is wrong first; none where there are
// over 200 sections. The same for any `threads`. Complexity: O(cells), and the sections squared.
std::vector<SectionPatch> find_patches(EditContext& edit, const SectionAreas& areas, std::uint32_t structure,
                                       std::uint32_t plane, int threads = 1);

// Cuts the edges that pass through the patch, so that it is a membrane of facets (without a path). Where the
// plane is nearer to a vertex than `near` of such an edge, that is a corner of the membrane. No facets where
// an edge can't be cut: what was done to the mesh then, as before, is the caller's to take back. `near`: [0,
// 0.5).
Membrane membrane_of_patch(EditContext& edit, const SectionAreas& areas, const SectionPatch& patch,
                           double near);

}  // namespace anatomesh
