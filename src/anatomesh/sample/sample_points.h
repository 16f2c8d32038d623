// sample_points: the points that the tetrahedralization is made of.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/sample/contour_segments.h"
#include "anatomesh/sample/protected_segments.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

struct SampleOptions {
    double size_mm = 0;   // edge length aimed at near the surface. 0: default_size(). [0.01, 1000]
    double growth = 0.5;  // how fast the edge length may grow with the depth inside, mm per mm. [0, 2]
    // Contour segments are split as finely as others beside them ask (split_encroached_subsegments.h), where
    // planes cross; those of several structures first as others of their slice ask, but about an axis.
    bool conforming = false;
    std::uint64_t max_points = 400'000'000;  // refused above, before the work
};

struct SampleStats {
    double size_mm = 0;                // the edge length used
    std::uint64_t contour_points = 0;  // distinct contour vertices
    std::uint64_t segment_points = 0;  // on contour segments: on long ones, and where two cross
    std::uint64_t surface_points = 0;  // on interfaces between the slices
    std::uint64_t thin_spots = 0;      // places where a wall or gap is thinner than half the size
    std::uint64_t lattice_points = 0;  // inside and, near the surface, outside
    std::uint64_t frame_points = 0;    // corners of a box far outside, so that no contour lies on the hull
};

// points[0, contour_points) are the distinct contour vertices at their exact coordinates, in order of first
// appearance; then the points on segments, on interfaces, of the lattice and of the frame, as
// SampleStats counts them.
struct PointSample {
    std::vector<Vec3> points;
    std::vector<std::uint32_t> contour_vertices;  // of every point of the contour set: its index into points
    std::vector<Subsegment> subsegments;          // what the contour segments were split into
    // Of the contour points and the split segments.
    ProtectedSegments protected_segments;
    bool graded = false;    // subsegments were split as finely as others beside them in their slices ask
    bool has_pole = false;  // a vertex where four planes or more through a line draw contours
    SampleStats stats;
};

// How thick each structure is drawn in the mean: twice the area of its contours over their length, mm. A plate of
// thickness t, seen edge on, gives t; a disc of radius r gives r. Requires: a kept contour set.
std::vector<double> mean_thickness(const ContourSet& contours);

// Whether planes cross and lie so close to each other that vertices along the contours are more than 1.5 of their
// spacings apart: the places between them are drawn more finely than the contours.
bool dense_planes(const ContourSet& contours, const SliceArrangement& arrangement,
                  const StructureField& field);

// How dense: the mean spacing of the vertices along the contours in 1.5 plane spacings; 0 for parallel
// planes.
double plane_density(const ContourSet& contours, const SliceArrangement& arrangement,
                     const StructureField& field);

// The edge length that suits the data: the geometric mean of the slice spacing and the mean spacing of the
// vertices along the contours, that is about the side of a square with the surface's area per contour vertex;
// between 0.5 and 2 spacings (of planes that cross and lie closer than two thirds of the vertex spacing,
// larger by the square of what is missing, up to 1.3 vertex spacings), and not above the mean thickness of
// what is drawn: a wall needs an edge length across it, and two where slices are as close: at most 0.49 of
// the thickness, or a spacing.
double default_size(const ContourSet& contours, const SliceArrangement& arrangement,
                    const StructureField& field);

// Contour vertices are kept exactly. Long segments get intermediate points. A body-centred cubic lattice fills
// the inside (coarser with depth) and one layer outside; its points near an interface are moved onto it. Where a wall or
// a gap of a structure is thinner than half the size, its surface gets points of a lattice up to 8 times finer, and contour
// segments along it are split as finely: walls down to about a twentieth of the size stay whole. No free
// point lies within half the size of a contour point or in the diametral ball of a contour segment, so that
// contour segments tend to be edges of the Delaunay tetrahedralization.
// Points between the slices are there from the start: points on parallel planes alone have Delaunay
// tetrahedralizations that grow faster than linearly.
// Errors: limit E-SMP-001 the size would need more points than max_points. Complexity: linear in the lattice
// points of the box. Same result at any thread count.
// Lattice: Labelle and Shewchuk, SIGGRAPH 2007 (body-centred cubic). Protection: Shewchuk, Comput. Geom. 22, 2002.
// `arrangement`: of the contours' slices; where none cross, segments are split as finely as others of their
// slice ask.
Result<PointSample> sample_points(const ContourSet& contours, const SliceArrangement& arrangement,
                                  const StructureField& field, const SampleOptions& options,
                                  RunContext& context);

}  // namespace anatomesh
