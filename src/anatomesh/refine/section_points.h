// find_section_points: vertices that the mesh lacks for its cross-sections by the planes of slices to be what is drawn.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/cull/labelled_mesh_view.h"
#include "anatomesh/geom/plane_sections.h"
#include "anatomesh/refine/refine.h"

namespace anatomesh {

// A stretch of the common line of two slices on which one draws the structure and the other one does not.
struct ContradictedPlace {
    std::uint32_t structure = 0;
    Vec3 from, to;
};

// The slices whose planes cross.
struct CrossedSlices {
    CrossingPlanes planes;  // by slice; a plane ends where its contours do
    // At structure * slices + slice: 1 / area drawn, or 0 where the slice does not say where the structure
    // is; 1 / mm^2.
    std::span<const double> weights;
    std::span<const ContradictedPlace> contradicted;  // where no surface meets all slices
};

struct SectionPointOptions {
    double least_of_cross_section =
        2e-4;  // a cross-section of which less is wrong, as a share of what is drawn, stays. [0, 1]
    double least_of_section = 2e-5;  // as that, of one cell's section. [0, 1]
    double clearance_mm = 0;         // of sections from where slices contradict each other. >= 0
    double min_spacing = 0.3;        // of a point from others, in roots of its section's area. > 0
};

struct SectionPointStats {
    std::uint64_t wrong = 0;    // of cells, in cross-sections that do not stay
    std::uint64_t refused = 0;  // of these: a vertex is too near, or it is in the ball of a contour segment
};

// A section of a cell by a plane is wrong where the cell is in a structure that is not drawn there, or the
// other way round, away from where slices contradict each other: cells all of whose vertices lie on surfaces
// may pass from one plane to the next through what a plane between them has drawn, where planes lie closer
// than edges are long. A point at its middle, a twentieth of its width beside the plane, becomes a vertex
// that is on one side of the surface, so that its cells are what is drawn. Points of larger sections come
// first; those of one round keep twice their spacing from each other, and out of the diametral balls of
// contour segments. `look`: as in refine.h. Complexity: O(look x planes). Same result at any thread count.
// Follows: the criterion of cross-sections (docs/stages/11-certificate.md, clause 2), met as Boissonnat and Oudot,
// Graph. Models 67, 2005, meet theirs.
SectionPointStats find_section_points(const LabelledMeshView& mesh, const CrossedSlices& slices,
                                      const OccupiedSpace& occupied, const SectionPointOptions& options,
                                      std::vector<std::uint32_t>& look, std::vector<Vec3>& found,
                                      RunContext& context);

}  // namespace anatomesh
