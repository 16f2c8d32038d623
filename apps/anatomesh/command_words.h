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

// One word, and the whole command, as a shell would need them typed.
std::string quoted_word(const std::string& word);
std::string quoted_command(int argc, const char* const* argv);

}  // namespace anatomesh
