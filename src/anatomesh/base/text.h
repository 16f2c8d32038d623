// Small operations on text that do not depend on the locale.
#pragma once

#include <string>
#include <string_view>

namespace anatomesh {

// ASCII letters to lower case; every other byte unchanged.
std::string lower_case(std::string_view text);

// The same, and blanks and tabs left out.
std::string lowered_without_blanks(std::string_view text);

}  // namespace anatomesh
