#include "anatomesh/field/stack/stack_field.h"

#include <optional>
#include <utility>

#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/field/stack/swept_field.h"
#include "anatomesh/field/warnings/shifted_slices.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/sweep.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_stack_field(const ContourSet& set,
                                                               const FieldOptions& options,
                                                               RunContext& context) {
    if (is_parallel(set)) {
        warn_about_shifted_slices(set, context);
        return make_parallel_field(set, options, context);
    }
    if (std::optional<Sweep> sweep = Sweep::of(set)) {
        warn_about_shifted_slices(set, context);
        return make_swept_field(std::move(*sweep), set, options, context);
    }
    return std::shared_ptr<const StructureField>();
}

}  // namespace anatomesh
