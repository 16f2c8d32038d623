#include "command_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace anatomesh {

namespace {

// Optimal string alignment distance (Damerau, 1964, neighbouring letters swapped once).
std::size_t letter_distance(const std::string& a, const std::string& b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
    for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
            }
        }
    }
    return d[a.size()][b.size()];
}

std::vector<std::string> long_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    return names;
}

Error unknown_word(const std::string& what, const std::string& word, const std::vector<std::string>& known,
                   const std::string& help) {
    const std::string near = nearest_word(word, known);
    return {ErrorKind::usage,
            "E-CMD-002",
            fmt::format("there is no {} '{}'", what, word.substr(0, 60)),
            {},
            near.empty() ? help : fmt::format("did you mean {}?", near)};
}

// "model" with "--sufrace x": the option and, when it takes one, its value.
Status check_option(const CLI::App& verb, const std::vector<std::string>& words, std::size_t at) {
    const std::string& word = words[at];
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const CLI::Option* option = verb.get_option_no_throw(name);
    if (!option) {
        const std::string help =
            fmt::format("{} --help-all lists the options",
                        verb.get_parent() ? "anatomesh " + verb.get_name() : verb.get_name());
        return unknown_word("option", name, long_names(verb), help);
    }
    const bool takes_value = option->get_items_expected_min() > 0;
    if (!takes_value || equals != std::string::npos) return Nothing{};
    if (at + 1 == words.size() || words[at + 1].rfind("--", 0) == 0) {
        return Error{ErrorKind::usage,
                     "E-CMD-001",
                     fmt::format("{} needs a value: {}", name, option->get_type_name()),
                     {},
                     ""};
    }
    return Nothing{};
}

std::string quoted(const std::string& word) {
    const auto plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               std::string_view("-_./:=,+%@").find(c) != std::string_view::npos;
    };
    if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
    if (word.size() > 60) return "";
    std::string best;
    std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const std::string& candidate : candidates) {
        const std::size_t distance = letter_distance(word, candidate);
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

Status check_words(const CLI::App& app, const std::vector<std::string>& words) {
    if (words.empty()) {
        return Error{
            ErrorKind::usage, "E-CMD-001", "a command is needed", {}, "anatomesh --help lists the commands"};
    }
    const CLI::App* verb = &app;
    if (words[0].empty() || words[0][0] != '-') {
        std::vector<std::string> verbs;
        verb = nullptr;
        for (const CLI::App* each : app.get_subcommands([](const CLI::App*) { return true; })) {
            verbs.push_back(each->get_name());
            if (each->get_name() == words[0]) verb = each;
        }
        if (!verb) {
            return unknown_word("command", words[0], verbs,
                                fmt::format("the commands are {}", fmt::join(verbs, ", ")));
        }
    }
    for (std::size_t i = verb == &app ? 0 : 1; i < words.size() && words[i] != "--"; ++i) {
        if (words[i].rfind("--", 0) != 0) continue;
        ANATOMESH_CHECK_STATUS(check_option(*verb, words, i));
    }
    return Nothing{};
}

std::string quoted_command(const std::vector<std::string>& words) {
    std::string line = "anatomesh";
    for (const std::string& word : words) line += " " + quoted(word);
    return line;
}

}  // namespace anatomesh
