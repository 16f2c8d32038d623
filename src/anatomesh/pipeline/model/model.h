// Model: a checked tetrahedral model with all that is known of it, and what is asked of it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "anatomesh/base/contract.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/routed_contour.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct ModelOptions {
    double size_mm = 0;  // target edge length. 0: from the slice spacing and the contours. [0.01, 1000]
    EndCaps caps = FieldOptions{}.caps;
    double max_gap_spacings = FieldOptions{}.max_gap_spacings;  // [1, 1e6]
    double single_slice_mm = FieldOptions{}.single_slice_mm;    // [0, 1000]
    double max_radius_edge = contract::max_radius_edge;         // aimed at for every cell. [1.2, 10]
    std::uint64_t max_tetrahedra = 1'000'000'000;               // refused above, before the work
    // Where planes cross, segments of contours that no edges of the surface run along follow it, if they need
    // not leave their place by more than this, mm, half an edge length (reroute_on_section.h) or, over
    // edges beside them, 0.6 of it (snap_round_segments.h). [0, 1000]; 0:
    // all stay where they are drawn
    double max_reroute_mm = 0;
    // At the first run with a default size, less is done for cells and segments where planes are dense (W-PIP-005).
    // That is where the contour vertices, times the square of plane_density(), are more than this. It is also where that
    // density is above 3. [0, any]
    std::uint64_t spare_dense_above = 100'000;
};

struct Model {
    TetMesh mesh;  // only cells of a region other than 0; every point is used by a cell
    RegionTable regions;
    std::vector<Structure> structures;  // as in the contour set
    ContourSet drawn;                   // the contours given
    ContourSet contours;  // the same, and where segments followed the surface the points of that
    std::vector<RoutedContour> routed;            // those, by the numbers of the contours given
    std::vector<std::uint32_t> contour_vertices;  // mesh vertex of every point of `contours`
    ModelReport report;  // everything the core can know; inputs and command are the caller's
    std::shared_ptr<const StructureField>
        field;  // what the mesh approximates: at p it is the field's at p - field_origin
    Vec3 field_origin;
};

}  // namespace anatomesh
