// section_of_field: where a structure's surface cuts a plane; propose_rings: what the slices drawn so far foretell there.
#pragma once

#include <cstdint>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh {

struct SectionOptions {
    double step_mm = 0.5;  // of the lattice on the plane: what is thinner may be missed. mm, [0.01, 100]
    double tolerance_mm = 0.05;  // rings stay within this of those with a vertex at each step. mm, [0, 10]
    std::uint64_t max_points = 16'000'000;  // of the lattice. points, [1, 1e9]
};

// Returns the boundary of where the field is negative on the plane: sound rings, outer ones counter-clockwise as seen
// along -normal and holes clockwise, in the order of their lexicographically smallest vertices, with which they begin. No rings
// where the plane misses the structure. Before they are thinned, vertices lie within a thousandth of a step of the surface.
// Guarantees: the same for any number of threads. Requires: options within their ranges. Errors: limit E-LIV-301 the
// lattice would have more points; cancelled. Complexity: a value for each point of the lattice over the field's box.
Result<StructureRings> section_of_field(const StructureField& field, std::uint32_t structure,
                                        const Plane& plane, const SectionOptions& options,
                                        RunContext& context);

// Why nothing is proposed. These are no errors.
enum class NothingProposed : std::uint8_t {
    none,         // something is
    one_slice,    // the structure is drawn on fewer than two slices
    drawn_here,   // it is drawn on the plane
    beyond_ends,  // the plane lies beyond its first or last slice
    nothing_here  // between its slices, but none of it reaches the plane
};

struct Proposal {
    StructureRings rings;  // empty where there is a reason
    NothingProposed reason = NothingProposed::none;
};

// Returns what the slices that draw the structure foretell on a plane on which it is not drawn: the section of the field of
// these slices alone. However far they lie apart they are joined, for who asks for a proposal between two slices
// says that the structure goes on. `set`: kept; structures that exclude each other are looked at one by one. Planes along others than the slices of a stack are never beyond its ends. Errors:
// those of make_structure_field() and section_of_field(). Complexity: theirs.
Result<Proposal> propose_rings(const ContourSet& set, std::uint32_t structure, const Plane& plane,
                               const FieldOptions& field, const SectionOptions& options, RunContext& context);

}  // namespace anatomesh
