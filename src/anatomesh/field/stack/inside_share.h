// How much of a strip, or of a column of strips, is inside by signed distances: for volumes by sampling.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace anatomesh {

// The share of a strip inside whose middle has a signed distance: what a point of a lattice stands for is cut
// by a boundary nearer than half the strip's width, which spoils the sum less than points wholly in or out.
struct Strip {
    double width;  // 0: a point

    double inside(double distance) const {
        if (width > 0) return std::clamp(0.5 - distance / width, 0.0, 1.0);
        return distance < 0;
    }
    // The mean of inside() over all distances from `a` to `b`.
    double mean_inside(double a, double b) const {
        return std::abs(b - a) <= 1e-9 * (std::abs(a) + std::abs(b)) ? inside(a)
                                                                     : (integral(b) - integral(a)) / (b - a);
    }

  private:
    double integral(double distance) const {
        const double half = 0.5 * width;
        if (distance <= -half) return distance;
        return distance >= half ? 0
                                : 0.5 * (distance - half) - 0.5 * (distance * distance - half * half) / width;
    }
};

// The same over the lower and the upper half of a way along which the distances are these at equal steps, an
// even number; between them a cubic has them (Catmull and Rom, 1974).
inline std::array<double, 2> inside_halves(const Strip& strip, std::span<const double> distances) {
    const std::size_t parts = distances.size() - 1;
    std::array<double, 2> halves{};
    for (std::size_t k = 0; k < parts; ++k) {
        const double from = distances[k], to = distances[k + 1];
        const double before = k > 0 ? distances[k - 1] : 2 * from - to,
                     beyond = k + 1 < parts ? distances[k + 2] : 2 * to - from;
        const double middle = 0.0625 * (9 * (from + to) - before - beyond);
        halves[2 * k / parts] += strip.mean_inside(from, middle) + strip.mean_inside(middle, to);
    }
    return {halves[0] / static_cast<double>(parts), halves[1] / static_cast<double>(parts)};
}

}  // namespace anatomesh
