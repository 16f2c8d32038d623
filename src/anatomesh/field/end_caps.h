// EndCaps by name: how options and reports write them.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

inline constexpr std::array<std::pair<EndCaps, const char*>, 3> end_caps_names{
    {{EndCaps::half, "half"}, {EndCaps::flat, "flat"}, {EndCaps::rounded, "rounded"}}};

inline const char* name_of(EndCaps caps) {
    for (const auto& [each, name] : end_caps_names) {
        if (each == caps) return name;
    }
    return "";
}

// Nothing for other texts.
inline std::optional<EndCaps> end_caps_of(std::string_view text) {
    for (const auto& [each, name] : end_caps_names) {
        if (text == name) return each;
    }
    return std::nullopt;
}

}  // namespace anatomesh
