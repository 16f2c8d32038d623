// The words of project files, for those that write and read them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "anatomesh/live/edit/drawing.h"

namespace anatomesh {

inline constexpr std::string_view project_format = "anatomesh-project";
// It rises with each change of the format that older programs would misread. [1; >= 1; D]
inline constexpr int project_version = 1;

// By the values of the enumerations.
inline constexpr std::array<std::string_view, 3> tool_names{"stroke", "polygon", "spline"};
inline constexpr std::array<std::string_view, 6> subject_names{"structure", "order",    "plane",
                                                               "rings",     "proposal", "pin"};

inline std::string_view name_of(RingTool tool) {
    return tool_names[static_cast<std::size_t>(tool)];
}
inline std::string_view name_of(Subject subject) {
    return subject_names[static_cast<std::size_t>(subject)];
}

}  // namespace anatomesh
