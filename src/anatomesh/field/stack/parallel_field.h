// The structure field of parallel slices. Reached through make_structure_field().
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/field/stack/structure_stack.h"

namespace anatomesh {

// How much of a field comes from an earlier one (FieldOptions::earlier).
struct TakenFromEarlier {
    std::size_t maps = 0, maps_taken = 0;  // distance maps of slices
    std::size_t gaps = 0, gaps_taken = 0;  // between two slices that both draw the structure
};

// Of all fields of parallel slices that a field is put together from.
TakenFromEarlier taken_from_earlier(const StructureField& field);

// Where values may differ between two fields of parallel slices, merged and rising; elsewhere they are the same bit for
// bit, but that of a structure which excludes others may be rounded otherwise where it is a clamp away. Nothing where they cannot be compared: others than fields of parallel slices, another frame, clamp or number of
// structures. A field that shares nothing with the earlier one differs everywhere. O(slices x structures).
std::optional<std::vector<FieldStretch>> stretches_unlike(const StructureField& field,
                                                          const StructureField& earlier);

// Requires: parallel slices, at least one contour. See make_structure_field() and docs/stages/05-field.md.
// FieldOptions::earlier saves all but what changed: maps of new outlines, motions between slices of which one of the
// next two on either side is new, and what is linear in the points.
Result<std::shared_ptr<const StructureField>> make_parallel_field(const ContourSet& set,
                                                                  const FieldOptions& options,
                                                                  RunContext& context);

}  // namespace anatomesh
