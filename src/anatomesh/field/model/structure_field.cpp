#include "anatomesh/field/model/structure_field.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <utility>

#include "anatomesh/field/planes/crossed_field.h"
#include "anatomesh/field/planes/general_field.h"
#include "anatomesh/field/warnings/missing_slices.h"
#include "anatomesh/field/overlaps/nested_field.h"
#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"
#include "anatomesh/field/planes/rotational_field.h"
#include "anatomesh/field/warnings/shifted_slices.h"
#include "anatomesh/field/stack/swept_field.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_structure_field(const ContourSet& set,
                                                                   const FieldOptions& options,
                                                                   RunContext& context) {
    assert(options.clamp_mm >= 0 && options.max_gap_spacings >= 1 && options.single_slice_mm >= 0);
    if (set.contours.empty()) {
        return Error{ErrorKind::geometry,
                     "E-FLD-001",
                     "there are no contours",
                     {set.source, "", "", "", ""},
                     "choose a structure that has contours"};
    }
    if (set.overlapping) return make_nested_field(set, options, context);
    if (is_parallel(set)) {
        warn_about_shifted_slices(set, context);
        return make_parallel_field(set, options, context);
    }
    if (std::optional<Sweep> sweep = Sweep::of(set)) {
        warn_about_shifted_slices(set, context);
        return make_swept_field(std::move(*sweep), set, options, context);
    }
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
