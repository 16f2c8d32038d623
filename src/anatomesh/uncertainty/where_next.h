// where_next: the planes on which one more contour would tell most about a surface.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/uncertainty/surface_uncertainty.h"

namespace anatomesh {

struct WhereNextOptions {
    std::uint32_t count = 5;  // planes to name. [1, 1000]
    FieldOptions field;       // as those of the model
};

struct NextPlane {
    Plane plane;
    std::int64_t slice_a = -1, slice_b = -1;  // it lies between these two; only a: beyond it
    double gain_mm3 = 0;                      // expected volume of error that its contours take away
    double gap_mm3 = 0;      // what of it is doubt whether structures go on where slices are missing
    double expected_mm = 0;  // mean error expected now along it, where it is nearer than any contour
    std::vector<double> gain_by_structure;  // mm^3
};

struct WhereNext {
    std::vector<NextPlane> planes;  // best first, each with those before it drawn
    double expected_mm3 = 0;        // of error on the whole surface and in gaps, now
    double gaps_mm3 = 0;            // what of it is in gaps
};

// Candidates are the planes half-way between every slice and its nearest ones of about its direction
// (parallel, or through their common line), those half a spacing to either side of every slice, and those
// half-way through the gaps in which slices are missing and structures are not joined (gap_doubts.h). A
// contour on a plane is taken to lie where the plane meets the surface: a vertex at the height h whose normal
// is at the angle a to the plane's is h / sin a from it. The gain is the integral over the surface of the
// expected error that the shorter way to the evidence takes away, and what it takes of the doubt in gaps.
// Planes are chosen one after the other, each taken as drawn for the next (greedy; within 63 % of the best
// choice: Nemhauser, Wolsey and Fisher, Math. Program. 14, 1978). Deterministic; ties go to the first slice.
// Complexity: O(slices x vertices near each plane), over at most 40,000 vertices.
WhereNext where_next(const ContourSet& set, const SurfaceUncertainty& uncertainty, const TetMesh& mesh,
                     const RegionTable& regions, const WhereNextOptions& options);

}  // namespace anatomesh
