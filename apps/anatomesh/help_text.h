#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

// The answer of --help and --help-all, in lines of at most 80 columns.
namespace anatomesh {

// The groups in which --help-all and the manual page list options, in that order.
namespace option_group {
inline constexpr const char* input = "Input";
inline constexpr const char* slices = "Slices and structures";
inline constexpr const char* method = "Method";
inline constexpr const char* clean_up = "Clean-up of the result";
inline constexpr const char* contour_repair = "Contour repair";
inline constexpr const char* crossing_planes = "Crossing planes";
inline constexpr const char* mesh = "Mesh";
inline constexpr const char* simulation = "Simulation";
inline constexpr const char* request = "Request";
inline constexpr const char* connection = "Connection";
inline constexpr const char* outputs = "Outputs";
inline constexpr const char* run = "Run";
}  // namespace option_group

const std::vector<std::string>& option_groups();

// Puts every option of `app` that is in no group yet into `group`. Each function that declares options calls it at its end.
void group_new_options(CLI::App& app, const char* group);

// One group of options of a command, each in the order of declaration.
struct OptionGroup {
    std::string title;
    std::vector<const CLI::Option*> options;
};

// All options of a command but its positional arguments, by group. Empty groups are left out.
std::vector<OptionGroup> options_by_group(const CLI::App& app);

// Help of one command. `most_used` names its most used options; if it is empty, or `complete`, all options are listed.
std::string command_help(const CLI::App& command, const std::vector<std::string>& most_used, bool complete);

// Help of the program: its commands by the headings given, its options and its exit codes.
struct CommandList {
    std::string title;
    std::vector<std::string> commands;
};
std::string program_help(const CLI::App& app, const std::vector<CommandList>& lists);

}  // namespace anatomesh
