// For tests: slices of structures side by side, and what their contours have in common.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "anatomesh/contour/drawn_slice_for_test.h"

namespace anatomesh::fixtures {

// Edges of one structure that another has the other way round, and their length.
inline double shared_length(const ContourSet& set, std::uint32_t structure) {
    double sum = 0;
    for (const Contour& own : set.contours) {
        if (own.structure != structure) continue;
        const auto p = set.points_of(own);
        for (std::size_t n = 0; n < p.size(); ++n) {
            const Vec3 a = p[n], b = p[(n + 1) % p.size()];
            for (const Contour& other : set.contours) {
                if (other.structure == structure) continue;
                const auto q = set.points_of(other);
                for (std::size_t m = 0; m < q.size(); ++m)
                    if (q[m] == b && q[(m + 1) % q.size()] == a) sum += length(b - a);
            }
        }
    }
    return sum;
}

inline bool keeps_every_vertex(const ContourSet& before, const ContourSet& after) {
    if (before.contours.size() != after.contours.size()) return false;
    for (const Contour& old : before.contours) {
        const bool found = std::any_of(after.contours.begin(), after.contours.end(), [&](const Contour& now) {
            if (now.structure != old.structure) return false;
            // In the same order round.
            const auto p = before.points_of(old), q = after.points_of(now);
            const auto start = std::find(q.begin(), q.end(), p[0]);
            if (start == q.end()) return false;
            std::size_t at = 0;
            for (std::size_t k = 0; k < q.size() && at < p.size(); ++k)
                at += q[(static_cast<std::size_t>(start - q.begin()) + k) % q.size()] == p[at];
            return at == p.size();
        });
        if (!found) return false;
    }
    return true;
}

inline Polygon box(double x0, double y0, double x1, double y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

// A side from (x0, y) to (x1, y) in so many steps, at heights y + wave sin.
inline Polygon side(double x0, double x1, int steps, double y, double wave) {
    Polygon points;
    for (int n = 0; n <= steps; ++n) {
        const double x = x0 + (x1 - x0) * n / steps;
        points.push_back({x, y + wave * std::sin(0.7 * x)});
    }
    return points;
}

// Two slabs over each other with a gap (or, below 0, an overlap) between their sides of so many steps each.
inline std::vector<Drawing> slabs(double gap, int below, int above) {
    Polygon low = side(20, 0, below, 0, 0.8), high = side(0, 20, above, gap, 0.8);
    low.push_back({0, -5});
    low.push_back({20, -5});
    high.push_back({20, 5});
    high.push_back({0, 5});
    return {{0, low}, {1, high}};
}

inline double signed_area(const ContourSet& set, const Contour& contour) {
    const auto p = set.points_of(contour);
    double twice = 0;
    for (std::size_t n = 1; n + 1 < p.size(); ++n) twice += cross(p[n] - p[0], p[n + 1] - p[0]).z;
    return 0.5 * twice;
}

}  // namespace anatomesh::fixtures
