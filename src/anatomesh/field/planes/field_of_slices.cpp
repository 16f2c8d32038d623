#include "anatomesh/field/planes/field_of_slices.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "anatomesh/field/planes/crossed_field.h"
#include "anatomesh/field/planes/general_field.h"
#include "anatomesh/field/planes/rotational_field.h"
#include "anatomesh/field/stack/stack_field.h"
#include "anatomesh/field/warnings/missing_slices.h"
#include "anatomesh/field/warnings/shifted_slices.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"
#include "anatomesh/slices/arrangement/stack_and_crossing.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_field_of_slices(const ContourSet& set,
                                                                   const FieldOptions& options,
                                                                   RunContext& context) {
    assert(!set.contours.empty());
    ANATOMESH_TRY(std::shared_ptr<const StructureField> stack, make_stack_field(set, options, context));
    if (stack) return stack;
    if (std::optional<RotationalSweep> sweep = RotationalSweep::of(set, options.max_gap_spacings))
        return make_rotational_field(std::move(*sweep), set, options, context);
    warn_about_shifted_slices(set, context);
    if (const std::optional<StackAndCrossing> slices = stack_and_crossing(set))
        return make_crossed_field(set, *slices, options, context);
    warn_about_missing_slices(set, context);
    FieldOptions general = options;
    general.least_reach_mm = std::max(options.least_reach_mm, reach_across_axis * rotation_axis(set).beside);
    return make_general_field(set, general, context);
}

}  // namespace anatomesh
