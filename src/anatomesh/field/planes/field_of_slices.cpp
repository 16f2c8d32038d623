#include "anatomesh/field/planes/field_of_slices.h"

#include <algorithm>
#include <cassert>

#include "anatomesh/field/planes/crossed_field.h"
#include "anatomesh/field/planes/general_field.h"
#include "anatomesh/field/planes/path_field.h"
#include "anatomesh/field/planes/rotational_field.h"
#include "anatomesh/field/stack/stack_field.h"
#include "anatomesh/field/warnings/missing_slices.h"
#include "anatomesh/slices/arrangement/slices_beside_paths.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_field_of_slices(const ContourSet& set,
                                                                   const SliceFacts& slices,
                                                                   const FieldOptions& options,
                                                                   RunContext& context) {
    assert(!set.contours.empty());
    ANATOMESH_TRY(std::shared_ptr<const StructureField> stack,
                  make_stack_field(set, slices.arrangement, options, context));
    if (stack) return stack;
    const SliceArrangement& arrangement = slices.arrangement;
    if (arrangement.is_along_paths()) return make_path_field(set, slices, options, context);
    warn_about_slices_beside_paths(set, arrangement, context);
    if (arrangement.kind == ArrangementKind::about_axis)
        return make_rotational_field(set, slices, options, context);
    if (arrangement.kind == ArrangementKind::stack_and_crossing)
        return make_crossed_field(set, slices, options, context);
    warn_about_missing_slices(set, arrangement.axis, context);
    FieldOptions general = options;
    general.least_reach_mm = std::max(options.least_reach_mm, reach_across_axis * arrangement.axis.beside);
    return make_general_field(set, slices.coverage, general, context);
}

}  // namespace anatomesh
