// Numbers as text and back, the same in every locale.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

namespace anatomesh {

// The whole of `text` as a finite decimal number, correctly rounded; nothing for anything else ("nan", "1,5",
// "1.2.3", "", "1e400", "0x10"). A leading plus sign is allowed.
inline std::optional<double> parse_number(std::string_view text) {
    if (!text.empty() && text.front() == '+') {
        text.remove_prefix(1);
        if (!text.empty() && text.front() == '-') return std::nullopt;
    }
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

// The whole of `text` as an integer within the range of T.
template <class T>
std::optional<T> parse_integer(std::string_view text) {
    if (!text.empty() && text.front() == '+') {
        text.remove_prefix(1);
        if (!text.empty() && text.front() == '-') return std::nullopt;
    }
    T value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

// Appends the shortest text that reads back as the same double.
inline void append_number(std::string& text, double value) {
    char buffer[32];
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

// The same for JSON. Its readers take a number without a point for an integer, which has no negative zero: -0 is "-0.0".
inline void append_json_number(std::string& text, double value) {
    if (value == 0 && std::signbit(value))
        text += "-0.0";
    else
        append_number(text, value);
}

template <class T>
void append_integer(std::string& text, T value) {
    char buffer[24];
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

// append_number() alone: how a report writes an option's value down.
inline std::string number_text(double value) {
    std::string text;
    append_number(text, value);
    return text;
}

// At most so many significant digits, for messages: significant_text(0.01234, 3) = "0.0123".
inline std::string significant_text(double value, int digits) {
    std::array<char, 40> buffer;
    return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                         std::chars_format::general, digits)
                               .ptr};
}

// Three significant digits: how most messages give a measure.
inline std::string brief(double value) {
    return significant_text(value, 3);
}

// The shortest text that reads back as the same double, for messages, with a decimal point or an exponent.
// pointed_text(2) = "2.0".
inline std::string pointed_text(double value) {
    std::string text = number_text(value);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
}

// With a fixed number of decimals: fixed_text(2.5, 2) = "2.50". "inf" and "nan" for what is not finite.
std::string fixed_text(double value, int decimals);

// Share of a total in percent: percent_text(1, 8, 1) = "12.5 %"; "0 %" of nothing.
std::string percent_text(double part, double total, int decimals);

// The shortest text that reads back as the same double, for messages: without an exponent from 1e-4 to 1e16.
// plain_text(0.0001) = "0.0001", where number_text() says "1e-04".
inline std::string plain_text(double value) {
    // Smaller numbers are written with an exponent, because zeros are hard to count.
    // [decimal exponent; < 0; D]
    constexpr int least_exponent = -4;
    // Numbers from this power on are written with an exponent: a double has 16 digits that are sure.
    // [decimal exponent; 1 to 17; D digits of doubles]
    constexpr int most_exponent = 16;
    std::array<char, 40> buffer;
    char* const end = buffer.data() + buffer.size();
    const std::string scientific(buffer.data(),
                                 std::to_chars(buffer.data(), end, value, std::chars_format::scientific).ptr);
    const std::size_t mark = scientific.find('e');
    if (mark == std::string::npos) return scientific;  // not finite
    const int exponent = std::atoi(scientific.c_str() + mark + 1);
    if (exponent < least_exponent || exponent >= most_exponent) return scientific;
    return {buffer.data(), std::to_chars(buffer.data(), end, value, std::chars_format::fixed).ptr};
}

}  // namespace anatomesh
