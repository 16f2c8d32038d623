// PictureGrid: where the pixels of a plane picture lie, in millimetres.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// A pixel by its column i and its row j.
struct Pixel {
    std::uint32_t i = 0, j = 0;
    friend bool operator==(const Pixel&, const Pixel&) = default;
};

// The pixel nearest to a point, and whether the point lies in the picture. The picture ends half a step beyond the
// centres of its last pixels.
struct NearestPixel {
    Pixel pixel;
    bool inside = true;
};

// The centre of pixel (i, j) lies at (i step.x, j step.y) in the picture's plane. Steps may differ.
struct PictureGrid {
    std::array<std::uint32_t, 2> size{0, 0};
    Vec2 step{1, 1};  // mm; finite and > 0

    std::size_t count() const { return std::size_t{size[0]} * size[1]; }
    std::uint32_t index(Pixel p) const { return p.j * size[0] + p.i; }
    Pixel pixel(std::uint32_t index) const { return {index % size[0], index / size[0]}; }
    Vec2 position(Pixel p) const { return {p.i * step.x, p.j * step.y}; }
    // The geometric mean of the two steps, in mm: the unit of lengths that follow the picture's resolution.
    double mean_step() const { return std::sqrt(step.x * step.y); }

    // Returns the pixel whose centre is nearest; of a point beyond the border, the pixel of the border.
    // Requires: a pixel at least; p is finite. O(1).
    NearestPixel nearest(Vec2 p) const;

    friend bool operator==(const PictureGrid&, const PictureGrid&) = default;
};

}  // namespace anatomesh
