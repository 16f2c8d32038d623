// The fixed parts of report.html.
#pragma once

#include <string_view>

namespace anatomesh {

extern const std::string_view report_style;          // CSS
extern const std::string_view report_viewer_script;  // JavaScript of the 3D view

}  // namespace anatomesh
