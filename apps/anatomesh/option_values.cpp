#include "option_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

// parse_number and parse_integer allow a leading plus, as files have it; a command line does not need one.
bool has_plus(const std::string& text) {
    return !text.empty() && text.front() == '+';
}

[[noreturn]] void refuse(const std::string& option, const std::string& text, const std::string& wanted) {
    throw CLI::ValidationError(option, fmt::format("'{}' is not {}", text, wanted));
}

}  // namespace

double strict_number(const std::string& option, const std::string& text, double low, double high) {
    const std::string wanted = fmt::format("a number from {} to {}, written as 1.5", low, high);
    const std::optional<double> value = has_plus(text) ? std::nullopt : parse_number(text);
    const bool negative_zero = value && *value == 0 && std::signbit(*value);
    if (!value || negative_zero || *value < low || *value > high) {
        refuse(option, text, wanted);
    }
    return *value;
}

std::uint32_t strict_count(const std::string& option, const std::string& text, std::uint32_t low,
                           std::uint32_t high) {
    const auto value = has_plus(text) ? std::nullopt : parse_integer<std::uint32_t>(text);
    if (!value || *value < low || *value > high) {
        refuse(option, text, fmt::format("a whole number from {} to {}", low, high));
    }
    return *value;
}

CLI::Option* add_number(CLI::App& app, const std::string& name, double& target, double low, double high,
                        const std::string& unit, const std::string& description) {
    const auto read = [name, &target, low, high](const std::string& text) {
        target = strict_number(name, text, low, high);
    };
    return app.add_option_function<std::string>(name, read, description)->type_name(unit);
}

CLI::Option* add_count(CLI::App& app, const std::string& name, std::uint32_t& target, std::uint32_t low,
                       std::uint32_t high, const std::string& description) {
    const auto read = [name, &target, low, high](const std::string& text) {
        target = strict_count(name, text, low, high);
    };
    return app.add_option_function<std::string>(name, read, description)->type_name("N");
}

void add_optional_count(CLI::App& app, const std::string& name, std::optional<std::uint32_t>& target,
                        std::uint32_t low, const std::string& description) {
    const auto read = [name, &target, low](const std::string& text) {
        target = strict_count(name, text, low, largest_count);
    };
    app.add_option_function<std::string>(name, read, description)->type_name("N");
}

CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& target,
                        const std::vector<std::string>& choices, const std::string& description) {
    const auto read = [name, &target, choices](const std::string& text) {
        if (std::find(choices.begin(), choices.end(), text) == choices.end()) {
            refuse(name, text, fmt::format("one of {}", fmt::join(choices, ", ")));
        }
        target = text;
    };
    return app.add_option_function<std::string>(name, read, description)
        ->type_name(fmt::format("{}", fmt::join(choices, "|")));
}

CLI::Option* add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& type,
                      const std::string& description) {
    const auto read = [name, &target](const std::string& text) {
        if (text.empty()) refuse(name, text, "a value");
        target = text;
    };
    return app.add_option_function<std::string>(name, read, description)->type_name(type);
}

CLI::Option* add_texts(CLI::App& app, const std::string& name, std::vector<std::string>& target,
                       const std::string& type, const std::string& description) {
    const auto read = [name, &target](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
            if (text.empty()) refuse(name, text, "a value");
        }
        target = texts;
    };
    return app.add_option_function<std::vector<std::string>>(name, read, description)
        ->type_name(type)
        ->allow_extra_args(false);
}

}  // namespace anatomesh
