// GreyPicture: a plane picture of grey values, placed in space; what a livewire is led by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/live/livewire/picture_grid.h"

namespace anatomesh {

// More columns or rows are refused: path costs then stay below 2^32. [pixels; 1 to 65535; B]
inline constexpr std::uint32_t most_pixels_of_side = 16384;
// More pixels are refused, before memory is taken for them; so many need 0.7 GB. [pixels; >= 1; B]
inline constexpr std::size_t most_pixels = std::size_t{1} << 24;

// The centre of the first pixel is plane.origin, columns follow plane.u and rows follow plane.v. Pixels run along rows:
// pixels.size() == grid.count(). A value that is not finite is unknown, and no error.
struct GreyPicture {
    PictureGrid grid;
    Plane plane;
    std::vector<float> pixels;  // in the image's own unit (CT: HU)
    std::string source;         // the file, as the user named it
};

// Returns whether a picture can be worked on. Errors, all of kind input or limit and with the picture's source as place:
//   E-LIV-101 it has no pixel;            E-LIV-102 it has more pixels than the limits above;
//   E-LIV-103 a step is not finite or not between 1e-6 and 1e7 mm, or one is 200 times the other;
//   E-LIV-104 the number of values is not that of the pixels;
//   E-LIV-105 the plane is not finite, or its axes are not perpendicular and of length 1.
// O(1); no pixel is looked at.
Status check_grey_picture(const GreyPicture& picture);

// Returns whether a point is finite. Errors: input E-LIV-106, with `name` ("point 17", "anchor") as its place. O(1).
Status check_picture_point(Vec2 point, const std::string& name);

}  // namespace anatomesh
