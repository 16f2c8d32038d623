// measure_model: the figures of a model and its certificate, the six clauses of the contract.
//
//   clause                                                    state
//   1 contour vertices on the surface, bit for bit            kept, moved or broken
//   2 contour segments are chains of surface edges, cross-
//     sections by the slices' planes the drawn regions        kept or moved where all are; else counted and stated,
//                                                             or broken
//   3 closed oriented 2-manifolds, positive cells, no overlap kept or broken
//   4 radius-edge ratio at most 2; dihedral angles            kept where both are met; else counted and stated, or broken
//   5 same input, same bytes                                  kept, by construction of the stages
//   6 volume by mesh equals the field's within 0.2 %          kept or broken, where the field is at hand
//
// A clause that cannot be checked because its input is not there (contours, field) is `not_promised_yet` and
// its evidence says "not checked". So are clauses 2 and 4 where they were measured and are not met, within
// what is tolerated: their evidence begins with "measured, not met", says by how much, and names the worst
// places. Clause 2 is broken where what the slices' planes cut out of a structure is grossly not what is drawn.
// Clause 4 is broken by cells that nothing forces: where more than 0.5 % of the cells are such cells above the bound,
// where there are such cells and the mean of all unforced ones is above 1.2, or where one is gross (base/contract.h).
#pragma once

#include <span>
#include <string_view>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct CertificateInput {
    const TetMesh& mesh;
    const RegionTable& regions;
    std::span<const Structure> structures;        // what the members of the regions are
    const ContourSet* contours = nullptr;         // kept; structures are matched by number
    std::span<const double> field_volumes_mm3{};  // per structure of `structures`; empty when not known
    bool made_by_this_run = true;                 // false: the model was read, nothing is known of its making
    const StructureField* field = nullptr;  // at p - field_origin that of the model at p; of the contours
    Vec3 field_origin{};
    std::string_view field_note{};  // how the field came about, or why there is none: for clause 6
    // The contours as some of them are re-routed in their slices; null: none does. Vertices and segments are
    // looked for as they are here, cross-sections and what forces cells go by what is drawn.
    const ContourSet* on_surface = nullptr;
};

// The model's structure that one of the contours is, by its number, or, when both have only one, that one;
// model.size() when there is none.
std::size_t matching_structure(std::span<const Structure> contours, std::size_t structure,
                               std::span<const Structure> model);

// Fills, and only these: structures, regions, quality, certificate, listed_cells and, of counts, those of the
// model; with contours also counts.slices, counts.contours, counts.contour_vertices, contours.sections,
// contours.sections_not_drawn and, of parallel slices, lengths.slice_spacing_mm; with a field `field`. Of what
// is there already it reads contours.routed. Structures are matched by matching_structure(); the vertices of a
// structure that the model lacks are not on its surface.
// Requires: mesh.regions.size() == mesh.cells.size(), every region in the table, members below
// structures.size(). Warnings of the context that tell of vertices moved by cleaning stand in the evidence of
// clause 1. Complexity: O(n log n): 250,000 cells take about 0.7 s on one thread, a third of it for
// check_mesh().
void measure_model(const CertificateInput& input, const RunContext& context, ModelReport& report);

// States of a measured report how far the contours are from where they were drawn, by report.crossing.movement
// and contours.routed, in the evidence of clause 1. Where that is more than half a slice spacing, clauses 1 and 2
// are `moved` if they are kept: they hold of contours that nobody drew there. Nothing changes where nothing
// moved.
void state_movement(ModelReport& report);

// Whether a clause is broken.
bool any_broken(std::span<const Clause> certificate);

}  // namespace anatomesh
