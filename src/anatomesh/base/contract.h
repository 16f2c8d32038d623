// The bounds of the six clauses that every model keeps: the stages work towards them, the certificate checks them.
//
// The clauses stand in docs/stages/11-certificate.md. A bound is tagged C where the contract sets it, and M where it was
// measured how much room a stage needs below one that the contract sets.
#pragma once

namespace anatomesh::contract {

// Clause 2. Share of a drawn region's area by which the model's cross-section may differ from it, 1. C
inline constexpr double section_tolerance = 0.001;
// Of a structure's drawn areas together, what is amiss on all slices together: above this the clause is broken, 1. C
inline constexpr double gross_section_share = 0.1;

// Clause 4. Circumradius over shortest edge that every cell aims at, 1. C
inline constexpr double max_radius_edge = 2.0;
// Cells above it that nothing forces may be this share of all cells, while the mean ratio of the cells that nothing
// forces is at most the next one, 1. C
inline constexpr double share_over_bound = 0.005;
inline constexpr double mean_radius_edge = 1.2;
// One cell that nothing forces and that is beyond these: the clause is not kept; 1, degrees. C
inline constexpr double bad_radius_edge = 4, bad_dihedral_degrees = 10;
// What operations may leave in exchange for something better: a little below the former, so that what comes after them
// does not carry it beyond, 1. M
inline constexpr double nearly_bad_radius_edge = 3.9;
// One such cell beyond these breaks the clause, whatever the shares; one that the contours force is too flat for any use,
// so that the clause is not kept; 1, degrees. C
inline constexpr double gross_radius_edge = 100, gross_dihedral_degrees = 0.05;
// A contour vertex nearer to another one, or to a segment, than this share of the mean edge forces its cells, 1. C
inline constexpr double forcing_share = 0.1;

// Clause 6. Relative difference of the volume by mesh from that of the field, 1. C
inline constexpr double volume_tolerance = 0.002;

}  // namespace anatomesh::contract
