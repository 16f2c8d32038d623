// report.html: a model's report as one page that works from disk, offline, in any browser of today.
#pragma once

#include <string>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh_io/report/report_scene.h"

namespace anatomesh {

// The page: 3D view (WebGL 2; without it a message in its place) with a plane that cuts the tetrahedra,
// counts, certificate, quality, structures, time per stage, the paper's figures beside it, warnings, listed
// cells, the log of the contours. Nothing is loaded from elsewhere; a content security policy says so. All
// text from outside is escaped. Requires: those of make_scene(). A page of 250,000 cells has about 9 MB.
std::string report_html(const ModelReport& report, const TetMesh& mesh, const RegionTable& regions,
                        const ContourSet* contours, const SceneOptions& options = {});

}  // namespace anatomesh
