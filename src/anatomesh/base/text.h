// Small operations on text that do not depend on the locale.
#pragma once

#include <string>
#include <string_view>

namespace anatomesh {

// Returns the text with ASCII letters in lower case and every other byte unchanged.
std::string lower_case(std::string_view text);

// Returns the same without blanks and tabs.
std::string lowered_without_blanks(std::string_view text);

}  // namespace anatomesh
