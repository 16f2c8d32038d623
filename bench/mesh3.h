// mesh3: CGAL's Mesh_3 on our field, to compare with. The only file here that includes it.
#pragma once

#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct Mesh3Options {
    double facet_radius_mm = 0;    // bound on the circumradius of surface facets, > 0
    double cell_radius_mm = 0;     // bound on the circumradius of cells, > 0
    double facet_distance_mm = 0;  // bound on the distance of facets from the surface, > 0
    double surface_error_mm = 0;   // how exactly points are placed on the surface, > 0
    double facet_angle_deg = 25;
    double radius_edge = 2;
    bool perturb_and_exude = false;  // the two steps that take slivers out
    double sliver_angle_deg = 0;     // the smallest dihedral angle that they aim at; 0: as large as it gets
    double sliver_time_limit = 20;   // s, for each of them
};

struct Mesh3Result {
    TetMesh mesh;  // the cells of a region, positive, with the points that they use
    RegionTable regions;
    double insert_seconds = 0, refine_seconds = 0, slivers_seconds = 0;
};

// Inserts every contour point, then refines by the criteria. Requires: the field of these contours.
// Compiled with ANATOMESH_MESH3_PARALLEL it runs on the threads that TBB is allowed.
Mesh3Result mesh3(const ContourSet& contours, const StructureField& field, const Mesh3Options& options);

}  // namespace anatomesh
