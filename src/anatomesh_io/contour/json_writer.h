// Writes the JSON of json_reader.h.
#pragma once

#include <string>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// One line per contour. Requires and guarantees: those of format_contours (write_contours.h).
std::string format_json_contours(const ContourSet& set);

}  // namespace anatomesh
