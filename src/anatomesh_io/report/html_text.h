// Text for an HTML page.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace anatomesh {

// Text from outside as HTML text or attribute value in double quotes: & < > " ' escaped, control characters
// and bytes that are not UTF-8 replaced by U+FFFD, newlines and tabs kept. Wrapped in <bdi> by
// outside_html(), so that its direction marks end with it.
std::string escape_html(std::string_view text);
std::string outside_html(std::string_view text);

// 1234567 as "1&#8239;234&#8239;567".
std::string grouped(std::uint64_t value);

// Fixed decimals, grouped before the point; an en dash for what is not finite.
std::string grouped(double value, int decimals);

std::string base64(std::string_view bytes);

}  // namespace anatomesh
