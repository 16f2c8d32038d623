// For tests: analytic solids cut into parallel slices.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "anatomesh/contour/clean/clean.h"

namespace anatomesh::fixtures {

inline constexpr double pi = std::numbers::pi;

using Polygon = std::vector<Vec2>;

// A regular polygon with the area of the circle.
inline Polygon circle(Vec2 centre, double radius, int corners) {
    const double step = 2 * pi / corners, reach = radius * std::sqrt(step / std::sin(step));
    Polygon polygon;
    for (int i = 0; i < corners; ++i) {
        polygon.push_back(centre + Vec2{reach * std::cos(i * step), reach * std::sin(i * step)});
    }
    return polygon;
}

inline Polygon rectangle(Vec2 low, Vec2 high) {
    return {low, {high.x, low.y}, high, {low.x, high.y}};
}

// The same polygon with corners at most `spacing` apart.
inline Polygon divided(const Polygon& polygon, double spacing) {
    Polygon result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        const int subsegments = std::max(1, static_cast<int>(std::ceil(length(b - a) / spacing)));
        for (int n = 0; n < subsegments; ++n)
            result.push_back(a + (static_cast<double>(n) / subsegments) * (b - a));
    }
    return result;
}

// Contours as a file would give them; structure n has number n + 1.
class Drawing {
  public:
    RawContours raw;

    void add(std::uint32_t structure, double z, const Polygon& polygon) {
        while (raw.structures.size() <= structure) {
            const auto number = static_cast<std::int32_t>(raw.structures.size()) + 1;
            raw.structures.push_back({number, "structure " + std::to_string(number), {}});
        }
        RawContour contour;
        contour.structure = structure;
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        contour.point_count = static_cast<std::uint32_t>(polygon.size());
        contour.name = "contour " + std::to_string(raw.contours.size());
        raw.contours.push_back(contour);
        for (const Vec2 q : polygon) raw.points.push_back({q.x, q.y, z});
    }

    // A ball cut at every z = (n + 1/2) spacing; corners about `corner_spacing` apart.
    void add_ball(std::uint32_t structure, Vec3 centre, double radius, double spacing,
                  double corner_spacing) {
        const int count = static_cast<int>(radius / spacing) + 1;
        for (int n = -count; n <= count; ++n) {
            const double z = (n + 0.5) * spacing, r2 = radius * radius - z * z;
            if (r2 <= 0.01 * radius * radius) continue;
            const int corners = std::max(6, static_cast<int>(2 * pi * std::sqrt(r2) / corner_spacing));
            add(structure, centre.z + z, circle({centre.x, centre.y}, std::sqrt(r2), corners));
        }
    }

    void move(const std::function<Vec3(Vec3)>& map) {
        for (Vec3& p : raw.points) p = map(p);
    }
};

inline ContourSet kept(const RawContours& raw, bool exclusive = false) {
    RunContext context;
    auto cleaned = clean_contours(raw, {}, context);
    if (!cleaned.ok()) {
        ADD_FAILURE() << to_line(cleaned.error());
        return {};
    }
    ContourSet set = std::move(cleaned).value().kept;
    set.exclusive = exclusive;
    return set;
}

}  // namespace anatomesh::fixtures
