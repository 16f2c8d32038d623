#include "anatomesh/field/make_structure_field.h"

#include <cassert>

#include "anatomesh/field/overlaps/nested_field.h"
#include "anatomesh/field/planes/field_of_slices.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_structure_field(const ContourSet& set,
                                                                   const SliceFacts& slices,
                                                                   const FieldOptions& options,
                                                                   RunContext& context) {
    assert(options.clamp_mm >= 0 && options.max_gap_spacings >= 1 && options.single_slice_mm >= 0);
    if (set.contours.empty()) {
        return Error{ErrorKind::geometry,
                     "E-FLD-001",
                     "the input has no contours",
                     {set.source, "", "", "", ""},
                     "choose a structure that has contours"};
    }
    if (set.overlapping) return make_nested_field(set, slices, options, context);
    return make_field_of_slices(set, slices, options, context);
}

Result<std::shared_ptr<const StructureField>> make_structure_field(const ContourSet& set,
                                                                   const FieldOptions& options,
                                                                   RunContext& context) {
    return make_structure_field(set, slice_facts_of(set, options.max_gap_spacings, context), options,
                                context);
}

}  // namespace anatomesh
