// The operations of repair_section_locally(). Each changes a few cells if that halves what is wrong in their
// sections, says whether it did, and leaves the cells made or reshaped in the context's `changed`.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/sections/refill_from_heights.h"
#include "anatomesh/improve/sections/section_areas.h"

namespace anatomesh {

// What the operations work on. All of it outlives them.
struct SectionEdit {
    EditContext& edit;
    SectionAreas& areas;
    const ContourOwners& owners;
    double least_wrong = 0;  // share of what is drawn; less is not repaired. >= 0

    bool is_worth_it(double wrong) const { return wrong > least_wrong; }
    // Whether so much less is wrong than before that a change may stay.
    static bool is_enough(double after, double before) { return after <= most_left * before; }

  private:
    // Share of the wrong area that a change may leave. [1; 0 to 1; M 2026-11, set not recorded]
    static constexpr double most_left = 0.5;
};

// Moves a free vertex to a place over or under a plane that its cells meet. It is settled then
// (edit_context.h), and fixed when it is moved once more. No facet between regions at it comes further from
// the field's surface than the context's `spike_mm`, or than it was.
bool move_across_plane(SectionEdit& section, std::uint32_t v, const CellBounds& bounds);

// Relabels a cell to a region beside it, as may_relabel() allows.
bool relabel_at_section(SectionEdit& section, std::uint32_t cell, Region to, const CellBounds& bounds);

// Relabels two cells of one region, on both sides of a facet in a plane, to a region beside one of them.
bool relabel_both_at_section(SectionEdit& section, const std::array<std::uint32_t, 2>& cells,
                             const CellBounds& bounds);

// Flips edge `e` of a cell, one of the surface that passes through a plane.
bool flip_across_plane(SectionEdit& section, std::uint32_t cell, int e, const CellBounds& bounds);

// Moves a free vertex along edge `e` of a cell onto its other end, which is settled. No more cells break the
// bounds than before.
bool collapse_across_plane(SectionEdit& section, std::uint32_t cell, int e, bool first_onto_second,
                           const CellBounds& bounds);

// Replaces the two cells at a facet in a plane by those of a new vertex, settled, on one side of the plane.
bool refill_beside_plane(SectionEdit& section, std::uint32_t cell, int facet, const CellBounds& bounds);

// The surface between regions `own` and `to` leaves a free vertex beyond a plane for a new one, settled, on
// this side: the vertex's cells of `own` are replaced, and those at the surface get the region `to`. The new
// vertex lies within the context's `spike_mm` of the field's surface.
bool leave_vertex_beyond_plane(SectionEdit& section, std::uint32_t v, Region own, Region to,
                               const CellBounds& bounds);

}  // namespace anatomesh
