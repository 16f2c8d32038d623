#include "anatomesh/live/draw/spline.h"

#include <cmath>
#include <cstddef>

#include "anatomesh/base/standard_arithmetic.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/live/draw/area/thin_line.h"
#include "anatomesh/live/draw/area/tool_ranges.h"
#include "anatomesh/live/draw/stroke.h"

namespace anatomesh {

namespace {

// A stretch between two controls has at most so many edges. [edges; power of 2; B]
constexpr int most_pieces = 4096;

// The stretch of the curve from p[1] to p[2].
class Stretch {
  public:
    Stretch(Vec2 a, Vec2 b, Vec2 c, Vec2 d) : p_{a, b, c, d} {
        for (int i = 0; i < 3; ++i) knot_[i + 1] = knot_[i] + std::sqrt(length(p_[i + 1] - p_[i]));
    }

    // The point at a share of the stretch, by repeated interpolation.
    Vec2 at(double share) const {
        const double t = knot_[1] + share * (knot_[2] - knot_[1]);
        const auto between = [&](Vec2 a, double from, Vec2 b, double to) {
            return (to - t) / (to - from) * a + (t - from) / (to - from) * b;
        };
        Vec2 a[3], b[2];
        for (int i = 0; i < 3; ++i) a[i] = between(p_[i], knot_[i], p_[i + 1], knot_[i + 1]);
        for (int i = 0; i < 2; ++i) b[i] = between(a[i], knot_[i], a[i + 1], knot_[i + 2]);
        return between(b[0], knot_[1], b[1], knot_[2]);
    }

    // Whether so many chords keep the tolerance; a curve of degree three is farthest within the inner quarters.
    bool is_within(double tolerance, int pieces) const {
        for (int k = 0; k < pieces; ++k) {
            const Vec2 from = at(static_cast<double>(k) / pieces), to = at((k + 1.0) / pieces);
            for (const double part : {0.25, 0.5, 0.75}) {
                if (distance_to_segment(at((k + part) / pieces), from, to) > tolerance) return false;
            }
        }
        return true;
    }

  private:
    Vec2 p_[4];
    double knot_[4] = {0, 0, 0, 0};
};

}  // namespace

std::vector<Vec2> closed_spline(std::span<const Vec2> controls, double tolerance_mm) {
    std::vector<Vec2> p = without_repeats(controls);
    while (p.size() > 1 && p.back() == p.front()) p.pop_back();
    const std::size_t n = p.size();
    if (n < 3) return p;
    std::vector<Vec2> polygon;
    for (std::size_t i = 0; i < n; ++i) {
        const Stretch stretch(p[(i + n - 1) % n], p[i], p[(i + 1) % n], p[(i + 2) % n]);
        int pieces = 1;
        while (pieces < most_pieces && !stretch.is_within(tolerance_mm, pieces)) pieces *= 2;
        polygon.push_back(p[i]);
        for (int k = 1; k < pieces; ++k) polygon.push_back(stretch.at(static_cast<double>(k) / pieces));
    }
    return polygon;
}

Result<DrawResult> draw_spline(const StructureRings& before, std::span<const Vec2> controls,
                               const SplineOptions& options) {
    const StandardArithmetic arithmetic;
    ANATOMESH_CHECK_STATUS(check_points(controls, "the spline"));
    ANATOMESH_CHECK_STATUS(
        check_option(options.tolerance_mm, least_tolerance_mm, most_tolerance_mm, "tolerance_mm"));
    return draw_polygon(before, closed_spline(controls, options.tolerance_mm), options.mode, options.clip);
}

}  // namespace anatomesh
