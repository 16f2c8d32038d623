#include "anatomesh/live/livewire/grey_picture.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "anatomesh/base/number_text.h"
#include "anatomesh/geom/numbers.h"

namespace anatomesh {

namespace {

// Smaller steps are refused as damaged: no pixel is measured at a nanometre. [mm; > 0; C]
constexpr double shortest_step_mm = 1e-6;
// Pixels that are longer, in their widths, come of a damaged header.
// [1; > 1; D slices of 10 mm of pixels of 0.05 mm]
constexpr double longest_pixel_in_widths = 200;
// Axes may differ from perpendicular ones of length 1 by the rounding of what states them: DICOM has 6 digits and more.
// [1; 0 to 0.01; D digits of files]
constexpr double frame_tolerance = 1e-4;

Error picture_error(const GreyPicture& picture, ErrorKind kind, const char* code, std::string message,
                    std::string value, std::string next_step) {
    return {
        kind, code, std::move(message), {picture.source, "", "", "", std::move(value)}, std::move(next_step)};
}

std::string size_text(const PictureGrid& grid) {
    return std::to_string(grid.size[0]) + " x " + std::to_string(grid.size[1]) + " pixels";
}

// The negated comparisons also catch NaN.
bool is_possible_step(double step) {
    return step >= shortest_step_mm && step <= coordinate_bound_mm;
}

bool is_frame(const Plane& plane) {
    const auto is_one = [](double value) { return std::abs(value - 1) <= frame_tolerance; };
    const auto is_zero = [](double value) { return std::abs(value) <= frame_tolerance; };
    for (const double coordinate : {plane.origin.x, plane.origin.y, plane.origin.z}) {
        if (!(std::abs(coordinate) <= coordinate_bound_mm)) return false;
    }
    return is_one(length(plane.u)) && is_one(length(plane.v)) && is_zero(dot(plane.u, plane.v)) &&
           is_one(dot(cross(plane.u, plane.v), plane.normal)) && is_one(length(plane.normal));
}

}  // namespace

NearestPixel PictureGrid::nearest(Vec2 p) const {
    assert(count() > 0 && std::isfinite(p.x) && std::isfinite(p.y));
    const auto along = [](double at, std::uint32_t side, bool& inside) {
        inside = inside && at >= -0.5 && at <= side - 0.5;
        return static_cast<std::uint32_t>(std::clamp(std::floor(at + 0.5), 0.0, side - 1.0));
    };
    NearestPixel nearest;
    nearest.pixel.i = along(p.x / step.x, size[0], nearest.inside);
    nearest.pixel.j = along(p.y / step.y, size[1], nearest.inside);
    return nearest;
}

Status check_grey_picture(const GreyPicture& picture) {
    const PictureGrid& grid = picture.grid;
    if (grid.size[0] == 0 || grid.size[1] == 0) {
        return picture_error(picture, ErrorKind::input, "E-LIV-101", "the picture has no pixel",
                             size_text(grid), "give a picture with a column and a row at least");
    }
    if (std::max(grid.size[0], grid.size[1]) > most_pixels_of_side || grid.count() > most_pixels) {
        return picture_error(
            picture, ErrorKind::limit, "E-LIV-102",
            "the picture has more pixels than a livewire can be led through", size_text(grid),
            "cut the picture, or make its pixels larger; " + std::to_string(most_pixels) +
                " pixels are possible, " + std::to_string(most_pixels_of_side) + " along a side");
    }
    const double shorter = std::min(grid.step.x, grid.step.y), longer = std::max(grid.step.x, grid.step.y);
    if (!is_possible_step(grid.step.x) || !is_possible_step(grid.step.y) ||
        longer > longest_pixel_in_widths * shorter) {
        return picture_error(picture, ErrorKind::input, "E-LIV-103", "the pixels cannot have this spacing",
                             number_text(grid.step.x) + " x " + number_text(grid.step.y) + " mm",
                             "correct the spacing of the picture");
    }
    if (picture.pixels.size() != grid.count()) {
        return picture_error(picture, ErrorKind::input, "E-LIV-104",
                             "the picture has another number of values than of pixels",
                             std::to_string(picture.pixels.size()) + " values, " + size_text(grid),
                             "give a value for each pixel");
    }
    if (!is_frame(picture.plane)) {
        return picture_error(picture, ErrorKind::input, "E-LIV-105",
                             "the picture's axes are no perpendicular directions of length 1", "",
                             "correct the position and the orientation of the picture");
    }
    return Nothing{};
}

Status check_picture_point(Vec2 point, const std::string& name) {
    if (std::isfinite(point.x) && std::isfinite(point.y)) return Nothing{};
    return Error{ErrorKind::input,
                 "E-LIV-106",
                 "a point on the picture is not finite",
                 {"", "", "", name, number_text(point.x) + ", " + number_text(point.y)},
                 "give finite coordinates in mm"};
}

}  // namespace anatomesh
