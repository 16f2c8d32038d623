// Option values, read strictly: the whole text, in one documented form, within a range; the same in any
// locale.
//
// Each function adds one option to a verb. A value that is no such thing ends the parsing with a
// CLI::ValidationError, which the program turns into exit code 2. An option given twice is refused.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anatomesh {

// A number with a point as decimal sign, no unit, no leading blank, plus or "-0". In [low, high].
CLI::Option* add_number(CLI::App& app, const std::string& name, double& target, double low, double high,
                        const std::string& unit, const std::string& description);

// A whole number in [low, high], digits only.
CLI::Option* add_count(CLI::App& app, const std::string& name, std::uint32_t& target, std::uint32_t low,
                       std::uint32_t high, const std::string& description);

// Counts given on the command line are no larger: more is a slip. [1; >= 1; C]
inline constexpr std::uint32_t largest_count = 1'000'000;

// A count up to that, and nothing where it is not given.
void add_optional_count(CLI::App& app, const std::string& name, std::optional<std::uint32_t>& target,
                        std::uint32_t low, const std::string& description);

// One of several words.
CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& target,
                        const std::vector<std::string>& choices, const std::string& description);

// Any text but the empty one.
CLI::Option* add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& type,
                      const std::string& description);

// Any text but the empty one, once per mention of the option.
CLI::Option* add_texts(CLI::App& app, const std::string& name, std::vector<std::string>& target,
                       const std::string& type, const std::string& description);

// The number that `text` is, by the rules of add_number. Throws CLI::ValidationError naming the option.
double strict_number(const std::string& option, const std::string& text, double low, double high);

// The whole number that `text` is, by the rules of add_count. Throws likewise.
std::uint32_t strict_count(const std::string& option, const std::string& text, std::uint32_t low,
                           std::uint32_t high);

}  // namespace anatomesh
