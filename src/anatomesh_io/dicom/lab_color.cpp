#include "anatomesh_io/dicom/lab_color.h"

#include <algorithm>
#include <cmath>

namespace anatomesh {

namespace {

// The white of sRGB and CIELAB here has these tristimulus values. [1; > 0; D CIE illuminant D65]
constexpr double white[3] = {0.95047, 1.0, 1.08883};
// Darker colours follow a line in place of the cube root. [1; 0 to 1; D CIE 15, CIELAB]
constexpr double epsilon = 216.0 / 24389;
// The line has this slope, so that both parts meet at epsilon. [1; > 0; D CIE 15, CIELAB]
constexpr double kappa = 24389.0 / 27;

double to_linear(double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
double from_linear(double c) {
    return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}
double to_f(double t) {
    return t > epsilon ? std::cbrt(t) : (kappa * t + 16) / 116;
}
double from_f(double f) {
    return f * f * f > epsilon ? f * f * f : (116 * f - 16) / kappa;
}

}  // namespace

std::array<std::uint8_t, 3> color_of_lab(std::string_view bytes, bool is_big_endian) {
    double stored[3];
    for (std::size_t i = 0; i < 3; ++i) {
        const auto low = static_cast<unsigned char>(bytes[2 * i + (is_big_endian ? 1 : 0)]);
        const auto high = static_cast<unsigned char>(bytes[2 * i + (is_big_endian ? 0 : 1)]);
        stored[i] = (high << 8 | low) / 65535.0;
    }
    const double fy = (100 * stored[0] + 16) / 116;
    const double fx = fy + (255 * stored[1] - 128) / 500, fz = fy - (255 * stored[2] - 128) / 200;
    const double x = white[0] * from_f(fx), y = white[1] * from_f(fy), z = white[2] * from_f(fz);
    const double linear[3] = {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                              -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                              0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
    std::array<std::uint8_t, 3> color{};
    for (std::size_t i = 0; i < 3; ++i)
        color[i] = static_cast<std::uint8_t>(std::lround(255 * from_linear(std::clamp(linear[i], 0.0, 1.0))));
    return color;
}

std::array<std::uint16_t, 3> lab_of_color(const std::array<std::uint8_t, 3>& color) {
    const double r = to_linear(color[0] / 255.0), g = to_linear(color[1] / 255.0),
                 b = to_linear(color[2] / 255.0);
    const double fx = to_f((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / white[0]);
    const double fy = to_f((0.2126729 * r + 0.7151522 * g + 0.0721750 * b) / white[1]);
    const double fz = to_f((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / white[2]);
    const double lab[3] = {(116 * fy - 16) / 100, (500 * (fx - fy) + 128) / 255,
                           (200 * (fy - fz) + 128) / 255};
    std::array<std::uint16_t, 3> stored{};
    for (std::size_t i = 0; i < 3; ++i)
        stored[i] = static_cast<std::uint16_t>(std::lround(65535 * std::clamp(lab[i], 0.0, 1.0)));
    return stored;
}

}  // namespace anatomesh
