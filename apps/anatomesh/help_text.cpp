#include "help_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace anatomesh {

namespace {

constexpr std::size_t line_width = 80;  // The narrowest terminal in use has 80 columns. [columns; > 40; D]
constexpr std::size_t description_column =
    30;  // The longest option name but one fits in front. [columns; > 0; D]

// `text` from the present column on, wrapped at spaces, with later lines indented by `indent`.
std::string wrapped(const std::string& text, std::size_t indent) {
    std::string out;
    std::size_t column = indent;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(' ', begin), text.size());
        const std::string word = text.substr(begin, end - begin);
        const bool is_first = column == indent;
        if (!is_first && column + 1 + word.size() > line_width) {
            out += "\n" + std::string(indent, ' ');
            column = indent;
        } else if (!is_first) {
            out += ' ';
            ++column;
        }
        out += word;
        column += word.size();
        begin = end + 1;
    }
    return out;
}

std::string entry(const std::string& head, const std::string& description) {
    std::string out = "  " + head;
    if (out.size() + 2 > description_column)
        out += "\n" + std::string(description_column, ' ');
    else
        out.resize(description_column, ' ');
    return out + wrapped(description, description_column) + "\n";
}

std::string names_of(const CLI::Option& option) {
    std::string names;
    for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
    for (const std::string& name : option.get_lnames()) names += (names.empty() ? "--" : ", --") + name;
    return names.empty() ? option.get_name(true) : names;
}

std::string entry(const CLI::Option& option) {
    std::string head = names_of(option);
    const bool is_positional = option.get_positional();
    if (!is_positional && option.get_items_expected_min() > 0) head += " " + option.get_type_name();
    const bool say_required = option.get_required() && !is_positional;
    return entry(head, option.get_description() + (say_required ? " Required." : ""));
}

std::string usage_of(const CLI::App& command) {
    std::string usage = "Usage: anatomesh " + command.get_name();
    for (const CLI::Option* option : command.get_options())
        if (option->get_positional()) usage += " " + option->get_name(true);
    for (const CLI::Option* option : command.get_options()) {
        if (option->get_positional() || !option->get_required()) continue;
        const bool is_short = !option->get_snames().empty();
        const std::string name = is_short ? "-" + option->get_snames()[0] : "--" + option->get_lnames()[0];
        usage += fmt::format(" {} {}", name, option->get_type_name());
    }
    return usage + " [OPTION]...\n";
}

}  // namespace

const std::vector<std::string>& option_groups() {
    static const std::vector<std::string> groups{
        option_group::input,      option_group::slices,         option_group::method,
        option_group::clean_up,   option_group::contour_repair, option_group::crossing_planes,
        option_group::mesh,       option_group::simulation,     option_group::request,
        option_group::connection, option_group::outputs,        option_group::run};
    return groups;
}

void group_new_options(CLI::App& app, const char* group) {
    for (CLI::Option* option : app.get_options([](CLI::Option*) { return true; })) {
        if (option == app.get_help_ptr() || option == app.get_help_all_ptr()) continue;
        const std::vector<std::string>& groups = option_groups();
        if (std::find(groups.begin(), groups.end(), option->get_group()) == groups.end())
            option->group(group);
    }
}

std::vector<OptionGroup> options_by_group(const CLI::App& app) {
    std::vector<OptionGroup> all;
    for (const std::string& title : option_groups()) {
        OptionGroup group{title, {}};
        for (const CLI::Option* option : app.get_options()) {
            if (!option->get_positional() && option->get_group() == title) group.options.push_back(option);
        }
        if (!group.options.empty()) all.push_back(std::move(group));
    }
    return all;
}

std::string command_help(const CLI::App& command, const std::vector<std::string>& most_used, bool complete) {
    std::string out = wrapped(command.get_description() + ".", 0) + "\n\n" + usage_of(command);
    for (const CLI::Option* option : command.get_options())
        if (option->get_positional()) out += entry(*option);
    if (complete || most_used.empty()) {
        for (const OptionGroup& group : options_by_group(command)) {
            out += "\n" + group.title + ":\n";
            for (const CLI::Option* option : group.options) out += entry(*option);
        }
    } else {
        out += "\nMost used options:\n";
        for (const std::string& name : most_used)
            if (const CLI::Option* option = command.get_option_no_throw(name)) out += entry(*option);
        std::size_t count = 0;
        for (const OptionGroup& group : options_by_group(command)) count += group.options.size();
        out += fmt::format("\nList all {} options: anatomesh {} --help-all\n", count, command.get_name());
    }
    return out + "\n" + command.get_footer() + "\n";
}

std::string program_help(const CLI::App& app, const std::vector<CommandList>& lists) {
    std::string out = wrapped(app.get_description() + ".", 0) + "\n\nUsage: anatomesh COMMAND [OPTION]...\n";
    for (const CommandList& list : lists) {
        out += "\n" + list.title + ":\n";
        for (const std::string& name : list.commands)
            out += entry(name, app.get_subcommand(name)->get_description() + ".");
    }
    out += "\nOptions:\n";
    for (const CLI::Option* option : app.get_options()) out += entry(*option);
    return out + "\nHelp on a command: anatomesh COMMAND --help\n\n" + app.get_footer() + "\n";
}

}  // namespace anatomesh
