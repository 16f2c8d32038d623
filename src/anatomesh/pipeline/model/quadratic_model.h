// quadratic_model: nodes on the edges of a finished model, on the smooth interfaces of its own field.
#pragma once

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/element/quadratic.h"
#include "anatomesh/pipeline/model/model.h"

namespace anatomesh {

// As quadratic_elements(); nodes on contour segments lie on them. The report of the model gets a stage
// "element" with the figures. Requires: the model was built from these contours. Error: cancelled.
Result<MidNodes> quadratic_model(Model& model, const ContourSet& contours, const QuadraticOptions& options,
                                 RunContext& context);

}  // namespace anatomesh
