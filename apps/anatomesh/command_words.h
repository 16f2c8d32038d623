// Checks of the words of a command before they are parsed: verbs and options that do not exist, with the
// nearest name that does, and options whose value is missing.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

// Errors: usage E-CMD-002, unknown verb or option; usage E-CMD-001, no value after an option that needs one.
Status check_words(const CLI::App& app, const std::vector<std::string>& words);

// The candidate nearest to `word`, by the number of letters to insert, drop, replace or swap; empty when none
// is near enough to be meant (a third of the letters).
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

// The command as a shell would need it typed; `words` are those behind the program's name.
std::string quoted_command(const std::vector<std::string>& words);

}  // namespace anatomesh
