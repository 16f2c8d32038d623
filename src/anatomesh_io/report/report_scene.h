// The model as the page's 3D view reads it: script elements of base64.
//
//   scene               JSON: low, step (of the 16 bit grid, per axis, mm), patient (axes are LPS),
//   structures (color),
//                       regions (members), in the order of the tables
//   points              3 x u16 per mesh point, on the grid
//   cells               4 x u24 per cell          cell-regions        u16 per cell
//   triangles           3 x u24 per facet between two regions, counter-clockwise seen from the second
//   sides               2 x u16 per facet: its regions
//   contours            3 x u16 per contour point, on the grid
//   contour-sizes       u24 per contour           contour-structures  u16 per contour
// Little endian. 250,000 cells take about 7 MB.
#pragma once

#include <string>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct SceneOptions {
    // Above, the cells are left out and the view cuts through the surface alone. Default: a page below 20 MB.
    std::size_t max_cells = 600'000;
};

struct Scene {
    std::string html;         // the script elements
    bool cells_drawn = true;  // false: left out by max_cells
    bool has_contours = false;
};

// `contours` may be null; its structures are those of the report, in order. Requires: mesh regions in the
// table, a mesh with at most 2^24 points.
Scene make_scene(const ModelReport& report, const TetMesh& mesh, const RegionTable& regions,
                 const ContourSet* contours, const SceneOptions& options);

}  // namespace anatomesh
