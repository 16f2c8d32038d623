#include "anatomesh/field/stack/paraboloid_caps.h"

#include <numbers>

namespace anatomesh {

namespace {

// A part whose area would be nothing only after so many gaps ends flat: the fall of its area tells no end.
// [gaps; > 1; M 2026-11 shells of 40 to 100 mm]
constexpr double bluntest = 8;
// A paraboloid cap is no higher, and so stays off the next slice, which shows nothing of the part.
// [gaps; 0 to 1; M 2026-11 shells of 40 to 100 mm]
constexpr double highest = 0.85;
// How much wider the part was on the slice before is looked for within so many greatest depths.
// [greatest depths; >= 1; B]
constexpr double widest_reach = 2.5;
// The deepest place of a section is found on a lattice of so many points a side. [points; >= 8; B]
constexpr int depth_lattice = 32;

double greatest_depth(const DistanceMap& section) {
    const Box2& box = section.region_box();
    const Vec2 step = (1.0 / depth_lattice) * (box.high - box.low);
    double depth = 0;
    for (int j = 0; j < depth_lattice; ++j) {
        for (int i = 0; i < depth_lattice; ++i)
            depth = std::max(depth, -section.value(box.low + Vec2{(i + 0.5) * step.x, (j + 0.5) * step.y}));
    }
    return depth;
}

// How much larger the part was on the slice before, mm^2: by the mean width of what it lost all around.
double lost_area(const DistanceMap& section, bool is_void, const DistanceMap& before) {
    double lost = 0, perimeter = 0;
    for (const Edge2& edge : section.edges()) {
        const double width = before.value(0.5 * (edge.a + edge.b)) * (is_void ? 1 : -1);
        const double along = length(edge.b - edge.a);
        lost += along * width;
        perimeter += along;
    }
    const double width = lost / perimeter;
    return width > 0 ? lost + std::numbers::pi * width * width : 0;
}

}  // namespace

std::optional<ParaboloidCap> paraboloid_cap_of(const DistanceMap& section, bool is_void,
                                               const DistanceMap& before, double gap_before, double gap) {
    const auto gaps_to_nothing = [&](const DistanceMap& larger) {
        const double lost = lost_area(section, is_void, larger);
        return lost > 0 ? section.area() * gap_before / (lost * gap) : bluntest;
    };
    double gaps = gaps_to_nothing(before);
    const double depth = greatest_depth(section), reach = widest_reach * depth;
    if (!(gaps < bluntest && depth > 0)) return std::nullopt;
    if (reach > before.limit())
        gaps = gaps_to_nothing(DistanceMap({before.edges().begin(), before.edges().end()}, reach));
    // Over a disc: the height at which a paraboloid that is so high has the volume of half the gap.
    const double top = gaps > 1 ? gaps * (1 - std::sqrt(1 - 1 / gaps)) : gaps;
    return ParaboloidCap(depth, gaps * gap, std::min(top, highest) * gap);
}

}  // namespace anatomesh
