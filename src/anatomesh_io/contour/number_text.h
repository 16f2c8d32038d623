// Numbers of files, and values of files in messages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

// A value from a file, short enough for a message.
inline std::string shown(std::string_view text) {
    // A message quotes no more of a text in a file, so that it stays one line. [bytes; >= 1; B]
    constexpr std::size_t longest = 40;
    return text.size() <= longest ? std::string(text) : std::string(text.substr(0, longest)) + "...";
}

}  // namespace anatomesh
