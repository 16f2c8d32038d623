// The closed shells of a structure's surface: how many, how large, and whether the contours know of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// voids and smallest_mm3 of a surface of outward triangles, whose shells are numbered as surface_topology()
// does. A shell of negative volume bounds a void. Complexity: linear.
ShellReport count_shells(std::span<const Vec3> points, std::span<const Triangle> surface,
                         std::span<const std::uint32_t> shell_of);

// The rest of the report, for the model's structure `structure`: contour structure s is the model's
// match[s], and vertex_of[n] the mesh vertex of contour point n, or no_cell. A shell is known by a vertex of
// a contour of any structure: the neighbour's contours tell where a structure ends too. In parts are contours
// of the structure itself. Complexity: linear.
void look_for_contours(std::span<const Vec3> points, std::span<const Triangle> surface,
                       std::span<const std::uint32_t> shell_of, const ContourSet& contours,
                       std::span<const std::size_t> match, std::size_t structure,
                       std::span<const std::uint32_t> vertex_of, ShellReport& report);

}  // namespace anatomesh
