// spurious_handles: small handles of a structure's surface that no contour of it is drawn beside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/check/small_handles.h"

namespace anatomesh {

// A handle within so many edge lengths is the mesh's own where no contour shows it.
// [1; > 0; M 2026-11 68 sets about an axis]
inline constexpr double spurious_handle_reach = 1.5;

// Contours with the mesh vertices of all their points, or no_cell.
struct ContourVertices {
    std::span<const Contour> contours = {};
    std::span<const std::uint32_t> vertices = {};
};

// Of the small handles (mesh/check/small_handles.h) of the structure's surface those that are more than the
// contours of the structure that lie wholly among their vertices, for these are drawings of them; less by
// that many. Requires, and complexity: as small_handles(); and linear in the contours for each part found.
std::vector<SmallHandles> spurious_handles(std::span<const Vec3> points, std::span<const Triangle> surface,
                                           std::uint32_t structure, const ContourVertices& drawn,
                                           double reach_mm);

}  // namespace anatomesh
