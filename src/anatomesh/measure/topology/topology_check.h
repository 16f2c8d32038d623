// topology_check: where a model's surface has another topology than the contours say.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/surface_mesh.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

// A run of slices through which a part of a structure goes on unchanged, and the surface along it.
struct TopologyMismatch {
    std::uint32_t structure = 0;
    std::uint32_t low_slice = 0, high_slice = 0;  // where most is amiss; equal: beyond the last slice
    std::int64_t euler = 0, expected = 0;  // of the surface; two less for every hole torn through a wall
    bool whole =
        false;  // the run ends beyond the first and the last slice, not where its part branches or vanishes
    bool by_mesh =
        true;  // the field goes by these slices, so the mesh tore it; else the field may have done so
    friend bool operator==(const TopologyMismatch&, const TopologyMismatch&) = default;
};

// Where a drawn part of a structure meets one part of the next slice alone, and what they have in common is
// in one piece with as many holes as each of them, the surface between is one annulus from every contour to
// one of the next slice: its Euler number is 0; and where the one part has holes, all of which lie within the
// other, which has none, these close by a disc each, which add one. Before the first slice and beyond the
// last one it closes without a handle. A hole through a wall takes two from the number, and so does a bridge
// to another wall; a gap that is filled may leave cavities, which add two. Where parts branch, vanish or slip
// past each other nothing is said; nor between slices further apart than 1.5 median gaps, or
// than 1.5 times the thickness that is stated of slices, of a structure on few of them (few_slices.h). Slices of a sweep
// are judged in its chart coordinates (sweep.h), of a stack with a few planes across it those of the
// stack, of planes in any position each family of parallel ones (stacks_of_slices.h), and for every structure
// the stack that sees most amiss counts; but between two slices nothing is said where contours of planes
// across turn back there, or lie there alone. `surfaces[s]` is the closed surface of the contour set's
// structure s as triangles of `points`; `vertex_of` the mesh vertex of every contour point, or no_cell. Of a
// structure with whole_only[s] != 0 those runs alone are asked for that are whole: the search ends where none
// is left. By structure, then by slice, the same for any `threads`. Complexity: O(t log t) for t triangles;
// the contours are compared only where a surface is no annulus.
std::vector<TopologyMismatch> topology_check(std::span<const Vec3> points,
                                             std::span<const std::vector<Triangle>> surfaces,
                                             const ContourSet& contours, const SliceArrangement& arrangement,
                                             std::span<const std::uint32_t> vertex_of,
                                             std::span<const std::uint8_t> whole_only, int threads = 1);

}  // namespace anatomesh
