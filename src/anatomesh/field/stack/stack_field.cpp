#include "anatomesh/field/stack/stack_field.h"

#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/field/stack/swept_field.h"
#include "anatomesh/field/warnings/displaced_slices.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_stack_field(const ContourSet& set,
                                                               const SliceArrangement& arrangement,
                                                               const FieldOptions& options,
                                                               RunContext& context) {
    if (arrangement.is_parallel()) {
        warn_about_displaced_slices(set, context);
        return make_parallel_field(set, options, context);
    }
    if (arrangement.sweep) {
        warn_about_displaced_slices(set, context);
        return make_swept_field(*arrangement.sweep, set, options, context);
    }
    return std::shared_ptr<const StructureField>();
}

}  // namespace anatomesh
