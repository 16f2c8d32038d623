// Shapes cut into slices, for the tests of this room.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/slice/scanline.h"

namespace anatomesh::fixtures {

using Ring = std::vector<Vec2>;  // counter-clockwise: outer, clockwise: hole

inline Ring circle(Vec2 centre, double radius, int count, double phase = 0) {
    Ring ring;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count + phase;
        ring.push_back(centre + Vec2{radius * std::cos(angle), radius * std::sin(angle)});
    }
    return ring;
}

inline Ring reversed(Ring ring) {
    return {ring.rbegin(), ring.rend()};
}

// A ring around `centre` with random radii in [low, high]: simple, spiky, with sharp convex and reflex
// corners.
inline Ring star(Vec2 centre, double low, double high, int count, std::mt19937& random) {
    std::uniform_real_distribution<double> radius(low, high);
    Ring ring;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count, r = radius(random);
        ring.push_back(centre + Vec2{r * std::cos(angle), r * std::sin(angle)});
    }
    return ring;
}

inline std::vector<Edge2> edges_of(const std::vector<Ring>& rings) {
    std::vector<Edge2> edges;
    for (const Ring& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) edges.push_back({ring[i], ring[(i + 1) % ring.size()]});
    }
    return edges;
}

inline double area_of(const Ring& ring) {
    double twice = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) twice += cross(ring[i], ring[(i + 1) % ring.size()]);
    return 0.5 * twice;
}

// Builds a kept contour set plane by plane; structures appear as they are used.
class SetBuilder {
  public:
    explicit SetBuilder(bool exclusive = false) {
        set.exclusive = exclusive;
        set.drawn = !exclusive;
        set.source = "fixture";
    }
    void slice(const Plane& plane) {
        set.slices.push_back({plane, static_cast<std::uint32_t>(set.contours.size()), 0, ""});
    }
    void ring(std::uint32_t structure, const Ring& points) {
        while (set.structures.size() <= structure) {
            const auto number = static_cast<std::int32_t>(set.structures.size()) + 1;
            set.structures.push_back({number, "S" + std::to_string(number), {200, 200, 200}});
        }
        Slice& at = set.slices.back();
        set.contours.push_back({structure, static_cast<std::uint32_t>(set.slices.size() - 1),
                                static_cast<std::uint32_t>(set.points.size()),
                                static_cast<std::uint32_t>(points.size())});
        ++at.contour_count;
        for (const Vec2 q : points) set.points.push_back(at.plane.to_space(q));
    }
    ContourSet set;
};

inline Plane axial(double z) {
    return {{0, 0, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

// A ball of `radius` around the origin, slices at z = first, first + spacing, ...
inline ContourSet ball(double radius, double first, double spacing, int corners) {
    SetBuilder builder;
    for (double z = first; z < radius; z += spacing) {
        builder.slice(axial(z));
        const double r2 = radius * radius - z * z;
        if (r2 > 0) builder.ring(0, circle({}, std::sqrt(r2), corners));
    }
    return builder.set;
}

}  // namespace anatomesh::fixtures
