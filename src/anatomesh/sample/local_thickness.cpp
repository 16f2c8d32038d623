#include "anatomesh/sample/local_thickness.h"

#include <algorithm>

namespace anatomesh {

std::optional<Vec3> LocalThickness::normal(std::uint32_t structure, Vec3 p) const {
    const double delta = reach_ / 16;
    const auto difference = [&](Vec3 step) {
        return field_.value(structure, p + step) - field_.value(structure, p - step);
    };
    const Vec3 gradient{difference({delta, 0, 0}), difference({0, delta, 0}), difference({0, 0, delta})};
    const double steepness = length(gradient);
    if (!(steepness > 0)) return std::nullopt;
    return (1.0 / steepness) * gradient;
}

double LocalThickness::depth(std::uint32_t structure, Vec3 p, Vec3 direction, bool expected) const {
    const auto as_expected = [&](double d) { return inside(structure, p + d * direction) == expected; };
    if (as_expected(0.5 * reach_) && as_expected(reach_)) return reach_;
    double low = reach_ / 16;
    if (!as_expected(low)) return low;
    for (const double share : {0.125, 0.1875, 0.25, 0.375, 0.5, 0.75, 1.0}) {
        double high = share * reach_;
        if (as_expected(high)) {
            low = high;
            continue;
        }
        for (int halving = 0; halving < 2; ++halving) {
            const double middle = 0.5 * (low + high);
            (as_expected(middle) ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }
    return reach_;
}

double LocalThickness::thickness(std::uint32_t structure, Vec3 p, Vec3 normal) const {
    return std::min(depth(structure, p, normal, false), depth(structure, p, -1.0 * normal, true));
}

}  // namespace anatomesh
