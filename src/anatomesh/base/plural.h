// A number with its noun: "1 vertex", "2 vertices".
#pragma once

#include <cstdint>
#include <string>

namespace anatomesh {

inline std::string counted(std::uint64_t count, const std::string& one, const std::string& several) {
    return std::to_string(count) + " " + (count == 1 ? one : several);
}

// This is for nouns that end in s when there are several.
inline std::string counted(std::uint64_t count, const std::string& one) {
    return counted(count, one, one + "s");
}

}  // namespace anatomesh
