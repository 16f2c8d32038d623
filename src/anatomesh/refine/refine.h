// refine: rounds of Delaunay refinement, of the interfaces and by circumradius / shortest edge.
//
// Each search looks at the cells of `look`, rising and without repeats, and leaves those of them in it that it wants to
// see again in the next round even if they do not change: the ones for which it found a point or none was allowed.
// All others need a look only when they change.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/cull/labelled_mesh_view.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/sample/protected_segments.h"

namespace anatomesh {

// What new points keep away from.
struct OccupiedSpace {
    const PointGrid& vertices;                    // all points of the mesh
    const ProtectedSegments& protected_segments;  // the diametral balls of subsegments
};

struct RefineOptions {
    double max_radius_edge = contract::max_radius_edge;  // cells above it are split. [1.2, 10]
    double flatness =
        0.004;  // cells with six volumes below this many cubes of their longest edge are split. [0, 0.1]
    double min_spacing = 0.75;  // of a new point from others, in shortest edges of its cell. (0, 1]
    double max_reach_mm = 10;   // points of one round keep at most this far from each other. > 0
    double protected_share =
        0.5;  // of the diametral balls of contour segments, kept free of points, by radius. [0, 1]
    std::span<const std::uint8_t>
        given;  // by point, not 0 for contour vertices; points beyond its end are none
    double crowded_mm =
        0;  // an edge between two of these counts as at least so long: their cells may be worse
    double surface_pull =
        0.35;  // a circumcentre this near an interface is moved onto it, in circumradii. [0, 0.5]
};

struct RefineStats {
    std::uint64_t above_bound = 0;  // of the cells looked at: inside, with a ratio above the bound
    std::uint64_t flat = 0;         // of these: inside or at an interface, and nearly flat
    std::uint64_t circumcenters = 0, surface_points = 0;  // points to insert
    std::uint64_t refused = 0;                            // bad cells for which no allowed point was found
    std::vector<std::uint32_t>
        balls;                    // of the protected segments: subsegments to split instead; rising, distinct
    double radius_edge_mean = 0;  // of those looked at that are inside
};

// Points that improve the cells inside: the circumcentre of each bad cell; where an interface lies between the cell
// and its circumcentre, the point where it is crossed; where one passes close to the circumcentre, the nearest point of it.
// A nearly flat cell, whose own circumcentre rounding spoils, takes that of its largest facet.
// Contour points are never moved, and no point goes into the protected share of the diametral
// ball of a subsegment: that subsegment is to be split instead, if it is longer than the cell's shortest
// edge. Points found in one round keep out of each other's empty spheres. Cells with a circumradius of many
// shortest edges wait for another round where a point was chosen that is in the way. Terminates when
// repeated: a circumcentre is farther from every point than twice the shortest edge of its cell, and points
// on interfaces keep min_spacing; so spacing never falls below a share of the contours' own. Complexity:
// linear in the cells looked at. Same result at any thread count. Follows: Shewchuk, Delaunay refinement mesh
// generation, 1997, chapter 4; Boissonnat and Oudot, Graph. Models 67, 2005.
RefineStats find_refinement_points(const LabelledMeshView& mesh, const OccupiedSpace& occupied,
                                   const RefineOptions& options, std::vector<std::uint32_t>& look,
                                   std::vector<Vec3>& found, RunContext& context);

struct CrossingOptions {
    double min_spacing = 0.3;  // of a crossing point from others, in lengths of its edge. (0, 1]
    double protected_share =
        1;  // of the diametral balls of contour segments, kept free of points, by radius. [0, 1]
    double shortest_mm = 0;  // edges with an end on another surface count from this length on. >= 0
};

struct CrossingStats {
    std::uint64_t crossing_edges =
        0;  // of the cells looked at: from one region to another with no vertex between
    std::uint64_t refused =
        0;  // of these: a vertex is already too near to the crossing, or a contour segment
    std::vector<std::uint32_t>
        balls;  // of the protected segments: subsegments to split instead; rising, distinct
};

// Points where mesh edges cross the surface of a structure that has one end inside and the other one outside,
// also where one end lies on that of another structure: the contour crosses
// a cell there, and a cell must have a vertex there before it can be split along it (the cut of the 2006
// method). A point keeps min_spacing lengths of its edge from every other one, and out of the protected share
// of the diametral ball of a subsegment: that subsegment is to be split. Complexity: O(n log n) in the cells
// looked at. Same result at any thread count.
CrossingStats find_crossing_points(const LabelledMeshView& mesh, const OccupiedSpace& occupied,
                                   const CrossingOptions& options, std::vector<std::uint32_t>& look,
                                   std::vector<Vec3>& found, RunContext& context);

struct DeviationOptions {
    double max_deviation_mm = 0.1;  // of the middle of an interface facet from the field's interface. > 0
    double min_spacing = 0.27;      // of a new point from others, in longest edges of its facet. (0, 1]
    double protected_share =
        0.5;  // of the diametral balls of contour segments, kept free of points, by radius. [0, 1]
};

struct DeviationStats {
    std::uint64_t deviating =
        0;  // interface facets of the cells looked at with their middle off the field's interface
    std::uint64_t refused =
        0;  // of these: no interface found near, a vertex too close to it, or a contour segment
};

// Points on the field's interface at the middle of those facets of the mesh's interfaces that are too far
// from it: where the surface is curved, or a structure is small, it needs more points than its contours give.
// Where the nearest place on the interface is taken - a pocket that closes between two slices has its facets
// in the plane of one, and its contour is nearest - the point is where the way from the middle to the farther
// vertex of the cell on the wrong side crosses it. Complexity: linear in the cells looked at. Same result at
// any thread count. Follows: the distance criterion of Boissonnat and Oudot, Graph. Models 67, 2005.
DeviationStats find_deviation_points(const LabelledMeshView& mesh, const OccupiedSpace& occupied,
                                     const DeviationOptions& options, std::vector<std::uint32_t>& look,
                                     std::vector<Vec3>& found, RunContext& context);

}  // namespace anatomesh
