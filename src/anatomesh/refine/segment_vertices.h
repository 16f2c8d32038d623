// What is known of mesh vertices from the contour segments that they lie on.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane_sides.h"
#include "anatomesh/sample/contour_segments.h"
#include "anatomesh/slices/coverage/slice_coverage.h"

namespace anatomesh {

// The slice of the contours that each of the vertices lies in, from its contour or along subsegments from
// there; no_slice (improve/core/drawn_slices.h) for all others and for those where planes cross. `vertex_of`:
// the vertex of every contour point. Complexity: O(vertices + subsegments).
std::vector<std::uint32_t> slices_of_vertices(const ContourSet& contours,
                                              std::span<const std::uint32_t> vertex_of,
                                              const std::vector<Subsegment>& subsegments,
                                              std::size_t vertex_count);

// The vertices at the ends of every contour segment, in the contours' order. O(points).
std::vector<std::array<std::uint32_t, 2>> segment_ends(const ContourSet& contours,
                                                       std::span<const std::uint32_t> vertex_of);

// What relabel() is to know of slices that are parallel; for all others both lists are empty.
struct PlanesOfStack {
    std::vector<std::uint32_t> slice_of;  // slices_of_vertices()
    std::vector<Plane> planes;            // by slice
};
PlanesOfStack planes_of_stack(const ContourSet& contours, const SliceArrangement& arrangement,
                              std::span<const std::uint32_t> vertex_of,
                              const std::vector<Subsegment>& subsegments, std::size_t vertex_count);

// What slices say of structures, for the facets of surfaces that meet their planes.
struct SliceWeights {
    std::vector<Plane> planes;    // by slice
    std::vector<Box2> extents;    // of their contours, in the planes; empty where these are parallel
    std::vector<double> weights;  // at structure * planes + slice: 1 / area drawn, or, if none is, in the
                                  // mean of the structure's slices; 1 / mm^2. 0 where the slice does not say
                                  // where the structure is, or any ends flat in its plane
    PlaneSides sides;             // of them; of a stack, those in which none ends flat
    double on_plane_mm = 0;       // vertices this near to a plane lie in it
};
// `facts`: of the contours. `ends`: planes in which something ends flat. O(points + structures x slices)
SliceWeights weigh_slices(const ContourSet& contours, const SliceFacts& facts,
                          const std::vector<Plane>& ends);

}  // namespace anatomesh
