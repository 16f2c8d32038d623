// Texts made from the program's own verbs and options, so that they cannot differ from them: completion
// scripts for shells and the manual page.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace anatomesh {

std::string bash_completion(const CLI::App& app);
std::string zsh_completion(const CLI::App& app);
std::string fish_completion(const CLI::App& app);

// In the man macros of troff.
std::string manual_page(const CLI::App& app, const std::string& version);

}  // namespace anatomesh
