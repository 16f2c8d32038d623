// Small tools of the text readers and writers: lines, numbers, errors with their place.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/base/text.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

Error mesh_error(const char* code, std::string message, const std::string& path, std::string value = {});
Error expected(const std::string& path, std::string_view what, std::string place);  // E-MDL-003

// E-MDL-005 unless every coordinate is finite and within 1e7 mm.
Status check_point(const Vec3& point, std::size_t index, const std::string& path);

// W-MDL-002 and W-MDL-005, when there is anything to warn of. `what`: "tetrahedra".
void warn_left_out(std::size_t count, const char* what, const std::string& path, RunContext& context);
void warn_polygons(std::size_t count, const std::string& path, RunContext& context);
// W-MDL-006. `what`: "grey values".
void warn_cell_values(const char* what, const std::string& path, RunContext& context);

inline bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

inline std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

// Takes the next word off the front of `rest`; empty at the end.
inline std::string_view take_word(std::string_view& rest) {
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    std::size_t size = 0;
    while (size < rest.size() && !is_blank(rest[size])) ++size;
    const std::string_view word = rest.substr(0, size);
    rest.remove_prefix(size);
    return word;
}

// The whole word as a number; nothing for anything else.
template <class T>
std::optional<T> number_of(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    T value{};
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc() || end != word.data() + word.size()) return std::nullopt;
    return value;
}

// Takes the next word as a number off the front of `rest`.
template <class T>
std::optional<T> take_number(std::string_view& rest) {
    return number_of<T>(take_word(rest));
}

// Appends the shortest text that reads back as the same number.
template <class T>
void append_number(std::string& text, T value) {
    char buffer[32];
    text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

// The lines of a text, with their numbers.
class Lines {
  public:
    explicit Lines(std::string_view text) : rest_(text) {}

    // Without the line feed; nothing at the end.
    std::optional<std::string_view> next() {
        if (rest_.empty()) return std::nullopt;
        const std::size_t end = rest_.find('\n');
        const std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        ++number_;
        return line;
    }
    std::string place() const { return "line " + std::to_string(number_); }
    std::string_view rest() const { return rest_; }

  private:
    std::string_view rest_;
    std::size_t number_ = 0;
};

}  // namespace anatomesh
