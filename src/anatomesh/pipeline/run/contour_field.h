// The field of a contour set as build_model() makes it, for checking a model that was made before.
#pragma once

#include <memory>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

// The set moved so that `origin` comes to lie at (0, 0, 0); every plane's own origin is the foot of that
// point on it.
ContourSet relative_to(Vec3 origin, ContourSet set);

struct ContourField {
    std::shared_ptr<const StructureField> field;  // at p - origin that of the contours at p
    Vec3 origin;
    std::vector<double> volumes_mm3;  // that it encloses, by structure of the set
};

// Requires: a kept contour set. Errors: those of make_structure_field() and field_volumes().
Result<ContourField> contour_field(const ContourSet& contours, const FieldOptions& options,
                                   RunContext& context);

}  // namespace anatomesh
