// The operations of improve_mesh(). Each tries one change of the mesh on an edit context, does it if it
// raises the least sine of the cells concerned, says whether it did, and leaves the cells made or reshaped in
// `changed`.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// A speculative context (edit_context.h) may try remove_edge, flip_edge, remove_facet and move_vertex; what
// it says depends, if it is local-only, on the cells that have a vertex of the cell (or the vertex), and on
// nothing else of the mesh. What it would change is its `proposal`.

// Takes away edge `e` of a cell: the cells round it are replaced by those of the best triangulation of its
// ring (dynamic programme of Klincsek, Annals of Discrete Mathematics 9, 1980). For an edge of the surface
// between two regions the facets at it are flipped: the ring is triangulated on either side of the new
// diagonal.
bool remove_edge(EditContext& edit, std::uint32_t cell, int e);

// Flips edge `e` of a cell, on the surface between two regions, whatever it does to the least sine as long as
// that stays above `good_sine` or does not fall.
bool flip_edge(EditContext& edit, std::uint32_t cell, int e, double good_sine);

// Takes away a facet between two cells of one region: three cells round the edge that joins their apices.
bool remove_facet(EditContext& edit, std::uint32_t cell, int facet);

// Moves a vertex uphill; on a surface between two regions along it.
bool move_vertex(EditContext& edit, std::uint32_t v);

// Relabels a cell to a region beside it, where the surface of every structure concerned stays a disc and near
// the field's interface, or, where three regions meet, within the tolerance of where it was: to the outside,
// or to where fewer of the cell's facets lie between two regions.
bool relabel_cell(EditContext& edit, std::uint32_t cell);

// Whether a cell may be relabelled to a region beside it so that the surface of every structure concerned
// stays a disc with the contours that it must have: if it comes inside with this sine and no higher ratio,
// and no facet of it that becomes one between two regions is further than `spike_mm`, and than those that
// were, from the field's interface.
bool may_relabel(EditContext& edit, std::uint32_t cell, Region to, const ContourOwners& owners,
                 double least_sine_inside, double most_ratio);

// Whether cells of one region may be relabelled together; they may even if one of them alone may not.
bool may_relabel_all(EditContext& edit, std::span<const std::uint32_t> cells, Region to,
                     const ContourOwners& owners, double least_sine_inside, double most_ratio);

// Moves vertex `from` onto `to`, the other end of edge `e` of a cell, and drops the cells at the edge.
bool collapse_edge(EditContext& edit, std::uint32_t cell, int e, bool first_onto_second);

// Collapses an edge for another purpose than shape. It does so if new cells inside have at least this sine
// and no larger ratio, or are no worse than those there. No facet of a surface may come further than
// `spike_mm` from the field's interface, or than it was.
bool collapse_edge_within(EditContext& edit, std::uint32_t cell, int e, bool first_onto_second,
                          double least_sine_inside, double most_ratio);

// Takes out the cells round edge `e` of a cell, and more where it helps, and joins a new vertex to the hole's
// facets.
bool insert_vertex(EditContext& edit, std::uint32_t cell, int e);

// Put a vertex on an edge of an interface, or on a facet of a cell, or into it, take out the cells there, and
// more where it helps, and join it to the hole's facets. Interfaces keep their place; an edge that is fixed
// becomes two. On an edge the cells round it are taken out, or, where that does not do, those round the edge
// opposite to it in the cell too.
bool split_edge(EditContext& edit, std::uint32_t cell, int e);
bool split_facet(EditContext& edit, std::uint32_t cell, int facet);
bool split_cell(EditContext& edit, std::uint32_t cell);

// Puts a vertex at some distance from a flat cell, where that and others flat beside it lie on an interface:
// takes out the cell and those between, and joins it to the hole's facets. Interfaces stay as they are.
bool insert_beside(EditContext& edit, std::uint32_t cell);

}  // namespace anatomesh
