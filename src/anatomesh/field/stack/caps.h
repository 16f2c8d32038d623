// How a structure ends beyond its last contour.
#pragma once

#include <algorithm>
#include <cmath>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// The prism over a contour, its rim rounded by a quarter circle of the given radius: at the height h, 0 <= h,
// what is further inside the contour than radius - sqrt(radius^2 - h^2). `d` is the signed distance from the
// contour in its plane; the value is that distance at h = 0, zero on the cap, and continuous. Requires:
// radius > 0.
inline double rounded_end(double d, double h, double radius) {
    const double x = d + radius;
    return x > 0 ? length(Vec2{x, h}) - radius : d * (1 - h / radius);
}

// The height of that cap over a point at the distance d: 0 outside.
inline double rounded_height(double d, double radius) {
    const double x = d + radius;
    if (x <= 0) return radius;
    return x < radius ? std::sqrt(radius * radius - x * x) : 0;
}

}  // namespace anatomesh
