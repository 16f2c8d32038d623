// report.json: a ModelReport as JSON. The format is schemas/report.schema.json.
#pragma once

#include <string>

#include "anatomesh/measure/report.h"

namespace anatomesh {

// Guarantees: UTF-8 (bytes that are not become U+FFFD), keys in a fixed order, figures that are not finite as
// null, the same in every locale; what may differ between two runs on the same input stands in the object
// `timing` alone: seconds, the command as typed, and the option `threads`.
std::string report_json(const ModelReport& report);

}  // namespace anatomesh
