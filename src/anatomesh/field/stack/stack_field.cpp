#include "anatomesh/field/stack/stack_field.h"

#include "anatomesh/field/stack/parallel_field.h"
#include "anatomesh/field/stack/swept_field.h"

namespace anatomesh {

Result<std::shared_ptr<const StructureField>> make_stack_field(const ContourSet& set,
                                                               const SliceArrangement& arrangement,
                                                               const FieldOptions& options,
                                                               RunContext& context) {
    if (arrangement.is_parallel()) return make_parallel_field(set, options, context);
    if (arrangement.sweep) return make_swept_field(*arrangement.sweep, set, options, context);
    return std::shared_ptr<const StructureField>();
}

}  // namespace anatomesh
