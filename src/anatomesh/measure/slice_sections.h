// slice_sections: how far the cross-sections of a model by the slices' planes are the drawn regions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/mesh/model/surface_mesh.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// One structure on one slice, mm^2.
struct SliceSection {
    std::uint32_t structure = 0, slice = 0;  // of the contour set
    double drawn = 0;                        // area of the drawn region; 0: it is not drawn there
    double difference = 0;  // area of its symmetric difference with the cross-section of the model
};

// For every structure and every slice, in the order of structures and then of slices. A slice on which a
// structure is not drawn says that it is not there; left out are slices without any contour where planes are
// not parallel, and those of which the field takes it that they say nothing of the structure
// (`coverage`, of the set). `surfaces[s]` is the surface of the contour set's
// structure s as outward triangles of `points`, closed; `vertex_of` the mesh vertex of every contour point,
// or no_cell (contour_fidelity()). The cross-section is of the solid with its boundary: a facet in the plane belongs to
// it. Where planes are not parallel, what lies beyond the box of a slice's contours is not compared: a plane
// says nothing there. Complexity: O(t log t) for t triangles, and those near each plane.
std::vector<SliceSection> slice_sections(std::span<const Vec3> points,
                                         std::span<const std::vector<Triangle>> surfaces,
                                         const ContourSet& contours, const SliceCoverage& coverage,
                                         std::span<const std::uint32_t> vertex_of);

// A vertex this near to a plane lies in it.
double on_plane_mm(const ContourSet& contours);

}  // namespace anatomesh
