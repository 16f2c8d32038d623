// Colours of DICOM segments: CIELab values in 16 bits each, and sRGB.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace anatomesh {

// The colour of RecommendedDisplayCIELabValue (0062,000D): six bytes. Follows: DICOM PS3.3 C.10.7.1.1, with
// the white point D65 that display programs use.
std::array<std::uint8_t, 3> color_of_lab(std::string_view bytes, bool is_big_endian);

// The inverse, to within one step of sRGB.
std::array<std::uint16_t, 3> lab_of_color(const std::array<std::uint8_t, 3>& color);

}  // namespace anatomesh
