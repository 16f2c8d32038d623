// shape_of_structure: volume and topology of what a contour set says of one structure.
#pragma once

#include <cstdint>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

struct StructureShape {
    double volume_mm3 = 0;
    std::uint64_t parts = 0, tunnels = 0, cavities = 0;
    bool is_counted = true;  // a coarser grid counts the same parts, tunnels and cavities
};

// Returns the shape of the field of the structure, on a grid of points: parts are 26-connected, cavities 6-connected,
// tunnels follow from Euler's number. What is thinner than a step of the grid may be missed or closed; the grid has some
// 50 steps across the slices, and two or more from slice to slice, 160 in all at most. Requires: a kept contour set with
// a contour of the structure. Errors: those of make_structure_field(). Complexity: some 100,000 values of the field.
Result<StructureShape> shape_of_structure(const ContourSet& set, std::uint32_t structure,
                                          const FieldOptions& options, const RunContext& context);

}  // namespace anatomesh
