#include "anatomesh/live/livewire/smooth_line.h"

#include <algorithm>

#include "anatomesh/base/standard_arithmetic.h"

namespace anatomesh {

namespace {

// So many binomial filters make a Gaussian of 1.4 points, which is wider than the steps of a digital line.
// [filters; 1 to 10; D a choice, measurement not recorded]
constexpr int filters = 4;

}  // namespace

std::vector<Vec2> smooth_line(std::span<const Vec2> points, bool closed, Vec2 step) {
    const StandardArithmetic arithmetic;
    const std::size_t count = points.size();
    std::vector<Vec2> line(points.begin(), points.end());
    if (count < 3) return line;
    std::vector<Vec2> next = line;
    for (int n = 0; n < filters; ++n) {
        for (std::size_t v = closed ? 0 : 1; v < (closed ? count : count - 1); ++v) {
            const Vec2 before = line[v == 0 ? count - 1 : v - 1], after = line[v + 1 == count ? 0 : v + 1];
            const Vec2 mean = 0.25 * (before + after) + 0.5 * line[v], centre = points[v];
            next[v] = {std::clamp(mean.x, centre.x - 0.5 * step.x, centre.x + 0.5 * step.x),
                       std::clamp(mean.y, centre.y - 0.5 * step.y, centre.y + 0.5 * step.y)};
        }
        std::swap(line, next);
    }
    return line;
}

}  // namespace anatomesh
