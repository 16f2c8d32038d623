// find_edge_features: what a livewire knows of each pixel of a picture, before anything was drawn on it.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/live/livewire/grey_picture.h"

namespace anatomesh {

struct EdgeFeatureOptions {
    // The standard deviation of the Gaussian that smooths the picture before it is differentiated, in mean pixel steps.
    // 0: none. [0, 5]
    double smoothing = 1.5;
    // The gradient magnitude that counts as a strong edge is this percentile of those on zero crossings, and not their
    // maximum: metal must not make all other edges look weak. [%; 50 to 100]
    double strong_percentile = 99;
};

enum class PixelKind : std::uint8_t {
    no_value,      // the pixel's value is not finite
    flat,          // the gradient is exactly 0: no direction
    slope,         // it has a gradient, and is no edge
    zero_crossing  // the Laplacian changes its sign here: the ridge of an edge
};

// A direction as a share of a whole turn: 65536 units; it wraps around as angles do.
using TurnAngle = std::uint16_t;

// Returns the angle from the x axis towards the y axis, rounded to units. Requires: the direction is finite, and not 0.
TurnAngle turn_angle(Vec2 direction);

// Flat arrays, parallel to the pixels. Memory: 15 bytes for each pixel.
struct EdgeFeatures {
    PictureGrid grid;
    std::vector<PixelKind> kind;
    std::vector<float> smoothed;                // grey value
    std::vector<float> gradient_x, gradient_y;  // of it, in grey values per mm, cut off at 1e38
    std::vector<TurnAngle> tangent;  // perpendicular to the gradient; the brighter side is on its right
    double strong_gradient = 0;      // in grey values per mm; 0: no zero crossing has a gradient
    double smoothing_mm = 0;         // the standard deviation in mm

    double gradient_magnitude(std::uint32_t pixel) const {
        const double x = gradient_x[pixel], y = gradient_y[pixel];
        return std::sqrt(x * x + y * y);
    }
    // The grey value between the four nearest pixels, and a NaN where one of them has none. Beyond the border it is that
    // of the border. O(1).
    double value_at(Vec2 p) const;
    // The grey values on the brighter and on the darker side of the edge through a pixel: two standard deviations of the
    // smoothing away, and one pixel at least. NaN if the pixel has no direction. O(1).
    struct Sides {
        double bright, dark;
    };
    Sides sides(std::uint32_t pixel) const;
};

// Smooths the picture in mm, so that unequal steps count as what they are. Pixels without a value, and those beyond the
// border, weigh nothing (normalized convolution): they make no edge. A picture of one grey value is flat exactly.
// A pixel is a zero crossing where the Laplacian has the other sign in one of four neighbours and is no nearer to 0
// there. strong_gradient leaves out as many of the strongest zero crossings as one pixel of metal makes, besides those
// above the percentile, and at most half of them. The result is the same for any number of threads.
// Errors: those of check_grey_picture; cancelled. Complexity: linear in pixels times the smoothing in steps, parallel.
// Sources: Mortensen and Barrett, SIGGRAPH 1995, section 3.1; Knutsson and Westin, CVPR 1993 (normalized convolution).
Result<EdgeFeatures> find_edge_features(const GreyPicture& picture, const EdgeFeatureOptions& options,
                                        RunContext& context);

}  // namespace anatomesh
