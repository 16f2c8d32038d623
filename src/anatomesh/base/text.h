// Small operations on text that do not depend on the locale.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace anatomesh {

// Returns the text with ASCII letters in lower case and every other byte unchanged.
std::string lower_case(std::string_view text);

// Returns the same without blanks and tabs.
std::string lowered_without_blanks(std::string_view text);

// Returns the length in bytes of the UTF-8 sequence at the start of `text`, or 0 if it is none: a NUL, an overlong form, a
// surrogate, or beyond U+10FFFF (RFC 3629). Requires: the text is not empty. O(1).
std::size_t utf8_length(std::string_view text);

// Returns whether all of `text` is UTF-8 without NUL. O(n).
bool is_utf8(std::string_view text);

}  // namespace anatomesh
