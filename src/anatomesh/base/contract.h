// The bounds of the six clauses that every model keeps: the stages work towards them, the certificate checks them.
//
// The clauses stand in docs/stages/11-certificate.md. A bound is tagged C where the contract sets it, and M where it was
// measured how much room a stage needs below one that the contract sets.
#pragma once

namespace anatomesh::contract {

// Clauses 1 and 2: contours that are farther from where they were drawn than this share of the slices' spacing
// are moved, and the clauses say so. What is nearer no slice beside it could tell from what was drawn.
// [1, of the spacing; > 0; C clauses 1 and 2]
inline constexpr double moved_share_of_spacing = 0.5;
// Clause 2: the model's cross-section differs from a drawn region by no more than this share of its area.
// [1, of the area; 0 to 1; C clause 2]
inline constexpr double section_tolerance = 0.001;
// Clause 2: if more of a structure's drawn areas together is amiss, the clause is broken and no model is
// written. [1, of the area; 0 to 1; C clause 2]
inline constexpr double gross_section_share = 0.1;

// Clause 4: every cell aims at a circumradius of so many shortest edges at most. [1; > 0.62; C clause 4]
inline constexpr double max_radius_edge = 2.0;
// Clause 4: cells above max_radius_edge that nothing forces may be this share of all cells, while
// mean_radius_edge is kept. [1, of the cells; 0 to 1; C clause 4]
inline constexpr double share_over_bound = 0.005;
// Clause 4: the mean ratio of the cells that nothing forces is at most this. [1; > 0.62; C clause 4]
inline constexpr double mean_radius_edge = 1.2;
// Clause 4: it is not kept if one cell that nothing forces has a larger ratio.
// [1; > max_radius_edge; C clause 4]
inline constexpr double bad_radius_edge = 4;
// Clause 4: it is not kept if one cell that nothing forces has a smaller dihedral angle.
// [degrees; 0 to 70.5; C clause 4]
inline constexpr double bad_dihedral_degrees = 10;
// Operations may leave such a ratio in exchange for something better: it is a little below the bound, so that
// what comes after does not carry it beyond.
// [1; max_radius_edge to bad_radius_edge; M 2026-11 pelvis, spine, skull, 61 labels, fetal brain]
inline constexpr double nearly_bad_radius_edge = 3.9;
// Clause 4: one cell that nothing forces above this ratio breaks it, whatever the shares; a forced one is too
// flat for any use, and the clause is not kept. [1; > bad_radius_edge; C clause 4]
inline constexpr double gross_radius_edge = 100;
// Clause 4: the same holds for a cell with a dihedral angle below this.
// [degrees; 0 to bad_dihedral_degrees; C clause 4]
inline constexpr double gross_dihedral_degrees = 0.05;
// Clause 4: a contour vertex nearer to another one, or to a segment, than this share of the mean edge forces
// its cells. [1, of the mean edge; 0 to 1; C clause 4]
inline constexpr double forcing_share = 0.1;

// Clause 6: the volume of the mesh differs by no more than this share from that of the field.
// [1, of the volume; 0 to 1; C clause 6]
inline constexpr double volume_tolerance = 0.002;

}  // namespace anatomesh::contract
