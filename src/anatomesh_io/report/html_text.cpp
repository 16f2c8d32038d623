#include "anatomesh_io/report/html_text.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// Length of the UTF-8 character at text[at], 0 when there is none: overlong forms, surrogates and what lies
// beyond U+10FFFF are none.
std::size_t utf8_length(std::string_view text, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return static_cast<unsigned char>(at + i < text.size() ? text[at + i] : 0);
    };
    const unsigned char lead = byte(0);
    if (lead < 0x80) return 1;
    const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    if (lead < 0xC2 || lead > 0xF4) return 0;
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0) != 0x80) return 0;
    }
    const unsigned char second = byte(1);
    const bool outside = (lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F) ||
                         (lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second > 0x8F);
    return outside ? 0 : length;
}

void append_grouped(std::string& out, std::string_view digits) {
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i > 0 && (digits.size() - i) % 3 == 0) out += "&#8239;";
        out += digits[i];
    }
}

}  // namespace

std::string escape_html(std::string_view text) {
    constexpr std::string_view replacement = "\xEF\xBF\xBD";
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = utf8_length(text, i);
        const char c = text[i];
        if (length == 0) {
            out += replacement;
            ++i;
            continue;
        }
        if (length > 1) {
            out += text.substr(i, length);
        } else if (c == '&') {
            out += "&amp;";
        } else if (c == '<') {
            out += "&lt;";
        } else if (c == '>') {
            out += "&gt;";
        } else if (c == '"') {
            out += "&quot;";
        } else if (c == '\'') {
            out += "&#39;";
        } else if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7F) {
            out += replacement;
        } else {
            out += c;
        }
        i += length;
    }
    return out;
}

std::string outside_html(std::string_view text) {
    return "<bdi>" + escape_html(text) + "</bdi>";
}

std::string grouped(std::uint64_t value) {
    std::string out;
    append_grouped(out, std::to_string(value));
    return out;
}

std::string grouped(double value, int decimals) {
    if (!std::isfinite(value)) return "&ndash;";
    const std::string text = fixed_text(std::abs(value), decimals);
    const std::size_t point = std::min(text.find('.'), text.size());
    std::string out = value < 0 && text.find_first_not_of("0.") != std::string::npos ? "&minus;" : "";
    append_grouped(out, std::string_view(text).substr(0, point));
    return out + text.substr(point);
}

std::string base64(std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t left = bytes.size() - i;
        const auto byte = [&](std::size_t k) -> std::uint32_t {
            return k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u;
        };
        const std::uint32_t word = byte(0) << 16 | byte(1) << 8 | byte(2);
        out += digits[word >> 18];
        out += digits[word >> 12 & 63];
        out += left > 1 ? digits[word >> 6 & 63] : '=';
        out += left > 2 ? digits[word & 63] : '=';
    }
    return out;
}

}  // namespace anatomesh
