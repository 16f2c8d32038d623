// spurious_joints: where a surface joins what the contours on it leave apart.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/vec.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// A patch of a structure's surface, between contours, with holes torn through a wall or bridges over a gap.
struct SpuriousJoint {
    std::uint32_t structure = 0;
    std::uint32_t slice = 0;  // of a contour at its rim
    std::uint32_t joints = 0;
    Vec3 place;  // the middle of that of its rims on a sheet, or of all, that is the shortest
    friend bool operator==(const SpuriousJoint&, const SpuriousJoint&) = default;
};

// Where planes cross, the contours on a surface are a net, and a patch is what a mesh of it holds: a disc, or
// what is left of one round contours that meet no other, or, of what passes between the planes, a tube. No
// contour tells of a handle within a patch; nor of a patch that fills two meshes: with two rims on sheets of
// the surface, each of which it lies within, it is a hole through the wall between the sheets, or a bridge
// over the gap. A rim is on a sheet if the mean of the unit normals of the facets beyond, those of a tube in
// no direction, is longer than 0.3, and goes round the patch as seen against it; but not one that is a whole
// contour: along such ones slices go on to each other. Not seen is a hole one rim of which goes round a
// chamber that it opens: that is a tube's.
// `surfaces[s]` is the closed surface of the contour set's structure s as triangles of `points`, or empty:
// not asked for; `edges` those along contours (sorted pairs, smaller vertex first); `missed` the segments
// along which none lead from end to end; `vertex_of` the mesh vertex of every contour point, or no_cell.
// Nothing is said of a patch with both ends of a missed segment: it is several that run together. Edges with
// the same patch on either side part nothing; in a patch with contour vertices within handles are not
// counted, for these may tell of them. By structure, then by the lowest triangle. Complexity: O(t log t) for
// t triangles, and for every structure that is asked for linear in the points and contours.
std::vector<SpuriousJoint> spurious_joints(std::span<const Vec3> points,
                                           std::span<const std::vector<Triangle>> surfaces,
                                           std::span<const std::array<std::uint32_t, 2>> edges,
                                           std::span<const std::array<std::uint32_t, 2>> missed,
                                           const ContourSet& contours,
                                           std::span<const std::uint32_t> vertex_of);

}  // namespace anatomesh
