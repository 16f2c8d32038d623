#include "anatomesh/base/number_text.h"

#include <array>
#include <charconv>

namespace anatomesh {

std::string fixed_text(double value, int decimals) {
    // The largest double has 309 digits before the point.
    std::array<char, 400> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                   std::chars_format::fixed, decimals);
    return end.ec == std::errc{} ? std::string(buffer.data(), end.ptr) : std::string("?");
}

std::string percent_text(double part, double total, int decimals) {
    return total > 0 ? fixed_text(100.0 * part / total, decimals) + " %" : std::string("0 %");
}

}  // namespace anatomesh
