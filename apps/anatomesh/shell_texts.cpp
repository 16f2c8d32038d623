#include "shell_texts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "help_text.h"

namespace anatomesh {

namespace {

struct OptionText {
    std::string short_name, long_name;  // "-o", "--output"; empty when there is none
    std::string type;                   // "FILE"; empty for a flag
    std::vector<std::string> choices;   // of "half|flat"
    std::string description, group;
};

struct VerbText {
    std::string name, description, examples;
    std::vector<OptionText> options;
    std::vector<OptionText> arguments;
    std::vector<std::string> words;  // that the argument can be, when it is one of a few
};

std::vector<std::string> choices_of(const std::string& type) {
    std::vector<std::string> words;
    if (type.find('|') == std::string::npos) return words;
    for (std::size_t begin = 0; begin <= type.size();) {
        const std::size_t end = std::min(type.find('|', begin), type.size());
        const std::string word = type.substr(begin, end - begin);
        if (word != "MM") words.push_back(word);  // "MM|exact": a number, or this word
        begin = end + 1;
    }
    return words;
}

OptionText text_of(const CLI::Option& option) {
    OptionText text;
    if (!option.get_snames().empty()) text.short_name = "-" + option.get_snames().front();
    if (!option.get_lnames().empty()) text.long_name = "--" + option.get_lnames().front();
    if (option.get_items_expected_min() > 0) text.type = option.get_type_name();
    text.choices = choices_of(text.type);
    text.description = option.get_description();
    text.group = option.get_group();
    return text;
}

std::vector<OptionText> options_of(const CLI::App& app) {
    std::vector<OptionText> texts;
    for (const CLI::Option* option : app.get_options()) {
        if (!option->get_positional()) texts.push_back(text_of(*option));
    }
    return texts;
}

std::vector<VerbText> verbs_of(const CLI::App& app) {
    std::vector<VerbText> verbs;
    for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
        VerbText text{
            verb->get_name(), verb->get_description(), verb->get_footer(), options_of(*verb), {}, {}};
        for (const CLI::Option* option : verb->get_options()) {
            if (!option->get_positional()) continue;
            text.arguments.push_back(text_of(*option));
            text.arguments.back().long_name = option->get_name(true);
            if (!text.arguments.back().choices.empty()) text.words = text.arguments.back().choices;
        }
        verbs.push_back(std::move(text));
    }
    return verbs;
}

std::vector<std::string> names_of(const std::vector<OptionText>& options) {
    std::vector<std::string> names;
    for (const OptionText& option : options) {
        if (!option.long_name.empty()) names.push_back(option.long_name);
        if (!option.short_name.empty()) names.push_back(option.short_name);
    }
    return names;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
        text.replace(at, from.size(), to);
    }
    return text;
}

// troff: a leading dot or quote is a macro, a backslash an escape, a minus sign a hyphen unless escaped.
std::string troff(const std::string& text) {
    std::string out = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
    if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out = "\\&" + out;
    return replaced(replaced(out, "\n.", "\n\\&."), "\n'", "\n\\&'");
}

std::string troff_options(const std::vector<OptionText>& options) {
    std::string out;
    for (const OptionText& option : options) {
        const bool both = !option.short_name.empty() && !option.long_name.empty();
        const std::string names = option.short_name + (both ? ", " : "") + option.long_name;
        out += fmt::format(".TP\n\\fB{}\\fR", troff(names));
        if (!option.type.empty()) out += fmt::format(" \\fI{}\\fR", troff(option.type));
        out += "\n" + troff(option.description) + "\n";
    }
    return out;
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
    std::string verbs, cases;
    for (const VerbText& verb : verbs_of(app)) {
        verbs += verb.name + " ";
        std::string values;
        for (const OptionText& option : verb.options) {
            if (option.choices.empty()) continue;
            values +=
                fmt::format("            {}) COMPREPLY=($(compgen -W '{}' -- \"$current\")); return ;;\n",
                            option.long_name, fmt::join(option.choices, " "));
        }
        if (!verb.words.empty()) {
            values +=
                fmt::format("            {}) COMPREPLY=($(compgen -W '{}' -- \"$current\")); return ;;\n",
                            verb.name, fmt::join(verb.words, " "));
        }
        if (!values.empty()) values = "        case $previous in\n" + values + "        esac\n";
        cases += fmt::format("    {})\n{}        options='{}' ;;\n", verb.name, values,
                             fmt::join(names_of(verb.options), " "));
    }
    return fmt::format(R"(# bash completion of anatomesh
_anatomesh() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} options=
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W '{}{}' -- "$current"))
        return
    fi
    case ${{COMP_WORDS[1]}} in
{}    esac
    case $current in
    -*) COMPREPLY=($(compgen -W "$options" -- "$current")) ;;
    *) COMPREPLY=($(compgen -f -- "$current")) ;;
    esac
}}
complete -o filenames -F _anatomesh anatomesh
)",
                       verbs, fmt::join(names_of(options_of(app)), " "), cases);
}

std::string zsh_completion(const CLI::App& app) {
    const auto quoted = [](const std::string& text) {
        // Inside a specification in single quotes, brackets and colons have a meaning of their own.
        std::string out = replaced(text, "'", "'\\''");
        for (const char* sign : {"[", "]", ":"}) out = replaced(out, sign, std::string("\\") + sign);
        return out;
    };
    std::string verbs, cases;
    for (const VerbText& verb : verbs_of(app)) {
        verbs += fmt::format("        '{}:{}'\n", verb.name, quoted(verb.description));
        cases += fmt::format("        {})\n            _arguments \\\n", verb.name);
        for (const OptionText& option : verb.options) {
            const std::string& name = option.long_name.empty() ? option.short_name : option.long_name;
            std::string value;
            if (!option.choices.empty()) {
                value = fmt::format(":value:({})", fmt::join(option.choices, " "));
            } else if (!option.type.empty()) {
                value = fmt::format(":{}:{}", option.type,
                                    option.type.find("FILE") != std::string::npos || option.type == "MODEL" ||
                                            option.type == "OUT"
                                        ? "_files"
                                        : " ");
            }
            cases += fmt::format("                '*{}[{}]{}' \\\n", name, quoted(option.description), value);
        }
        cases += verb.words.empty()
                     ? "                '*:file:_files'\n"
                     : fmt::format("                '1:value:({})'\n", fmt::join(verb.words, " "));
        cases += "            ;;\n";
    }
    return fmt::format(R"(#compdef anatomesh
# zsh completion of anatomesh
_anatomesh() {{
    local -a verbs
    verbs=(
{}    )
    if (( CURRENT == 2 )); then
        _describe verb verbs
        return
    fi
    local verb=$words[2]
    shift words
    (( CURRENT-- ))
    case $verb in
{}    esac
}}
_anatomesh "$@"
)",
                       verbs, cases);
}

std::string fish_completion(const CLI::App& app) {
    const auto quoted = [](const std::string& text) {
        return replaced(replaced(text, "\\", "\\\\"), "'", "\\'");
    };
    std::string out = "# fish completion of anatomesh\n";
    for (const VerbText& verb : verbs_of(app)) {
        out += fmt::format("complete -c anatomesh -n __fish_use_subcommand -a {} -d '{}'\n", verb.name,
                           quoted(verb.description));
        for (const OptionText& option : verb.options) {
            out += fmt::format("complete -c anatomesh -n '__fish_seen_subcommand_from {}'", verb.name);
            if (!option.short_name.empty()) out += " -s " + option.short_name.substr(1);
            if (!option.long_name.empty()) out += " -l " + option.long_name.substr(2);
            if (!option.choices.empty()) {
                out += fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
            } else if (!option.type.empty()) {
                out += " -r";
            }
            out += fmt::format(" -d '{}'\n", quoted(option.description));
        }
        if (!verb.words.empty()) {
            out += fmt::format("complete -c anatomesh -f -n '__fish_seen_subcommand_from {}' -a '{}'\n",
                               verb.name, fmt::join(verb.words, " "));
        }
    }
    return out;
}

std::string manual_page(const CLI::App& app, const std::string& version) {
    std::string out =
        fmt::format(".TH ANATOMESH 1 \"\" \"anatomesh {}\" \"User Commands\"\n", troff(version));
    out += ".SH NAME\nanatomesh \\- " + troff(app.get_description()) + "\n";
    out += ".SH SYNOPSIS\n.B anatomesh\n.I COMMAND\n[\\fIOPTION\\fR]... [\\fIFILE\\fR]...\n";
    out += ".SH OPTIONS\n" + troff_options(options_of(app)) + ".SH COMMANDS\n";
    for (const VerbText& verb : verbs_of(app)) {
        out += fmt::format(".SS {}\n{}.\n", troff(verb.name), troff(verb.description));
        for (const OptionText& argument : verb.arguments) {
            out +=
                fmt::format(".TP\n\\fI{}\\fR\n{}\n", troff(argument.long_name), troff(argument.description));
        }
        for (const std::string& group : option_groups()) {
            std::vector<OptionText> options;
            std::copy_if(verb.options.begin(), verb.options.end(), std::back_inserter(options),
                         [&](const OptionText& option) { return option.group == group; });
            if (!options.empty()) out += ".PP\n.I " + troff(group) + "\n" + troff_options(options);
        }
        if (!verb.examples.empty()) out += fmt::format(".PP\n.nf\n{}\n.fi\n", troff(verb.examples));
    }
    out += ".SH EXIT STATUS\n.nf\n" + troff(app.get_footer()) + "\n.fi\n";
    return out;
}

}  // namespace anatomesh
