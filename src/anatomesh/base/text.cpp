#include "anatomesh/base/text.h"

namespace anatomesh {

std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return lower;
}

std::string lowered_without_blanks(std::string_view text) {
    std::string result = lower_case(text);
    std::erase_if(result, [](char c) { return c == ' ' || c == '\t'; });
    return result;
}

}  // namespace anatomesh
