// Where a model and the field that it was made of hold different space.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/structure.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// Of the points of a lattice that lie inside a structure in the model alone, or in the field alone, the one
// farthest from the structure's surface in the model. farthest_from_field() measures from the model's
// surface; a part that the model lacks has none there. A part is found when a point of the lattice falls into
// it: a sheet half as thick as the lattice is wide and eight of its squares large is missed once in a few
// hundred times.
//
// `surfaces[s]`: the facets of structure s, of `points`, closed. The lattice of a structure is as wide as its
// edges are long in the mean, with at most 100,000 points, by the root of their number fewer where there are
// several structures; its columns run along z and are turned and shifted so that no straight wall follows
// them. A point of the model is told by the facets above it in its column (even-odd; exact predicates, with
// the column moved by an infinitely small step where it meets an edge: Edelsbrunner and Muecke, ACM Trans.
// Graph. 9, 1990). `of_field`: the field's structure of each of `structures`, or no_cell: such a one is left
// out. The field is at p - origin that of the model at p. Same figures for any number of threads. Complexity:
// a query of the field for each point, a search for the nearest facet for each that differs.
FieldDifferenceReport field_difference(std::span<const Vec3> points,
                                       const std::vector<std::vector<Triangle>>& surfaces,
                                       std::span<const Structure> structures,
                                       std::span<const std::uint32_t> of_field, const StructureField& field,
                                       Vec3 origin, int threads);

}  // namespace anatomesh
