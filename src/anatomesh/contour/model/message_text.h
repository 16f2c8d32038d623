// Numbers in messages of this room.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace anatomesh {

// Three significant digits, the same in every locale.
inline std::string brief(double number) {
    std::array<char, 32> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), number, std::chars_format::general, 3);
    return std::string(buffer.data(), end.ptr);
}

// The shortest text that reads back as the same number, with a decimal point.
inline std::string full(double number) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
    std::string result(buffer.data(), end);
    if (result.find_first_of(".en") == std::string::npos) result += ".0";
    return result;
}

}  // namespace anatomesh
