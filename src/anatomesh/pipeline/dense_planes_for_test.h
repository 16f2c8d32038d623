// For tests: a ball cut by planes that lie closer to each other than the vertices along their contours.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "anatomesh/pipeline/random_solids_for_test.h"
#include "anatomesh/pipeline/solid_fixtures_for_test.h"
#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::dense_plane_sets {

inline constexpr double radius = 20;

// A ball swept by planes whose places and tilts jitter by more than the gaps between them.
inline ContourSet sweep(int planes, int corners) {
    random_solids::Random random(5);
    RawContours raw;
    raw.structures.push_back({1, "ball", {}});
    for (int k = 0; k < planes; ++k) {
        const Vec3 n = normalized(
            {0.1 * std::sin(0.1 * k) + random.between(-0.02, 0.02), random.between(-0.02, 0.02), 1});
        const double h = radius * ((2.0 * k + 1) / planes - 1) * 0.98;
        const Plane plane = make_plane(h * n, n);
        raw.planes.push_back(plane);
        raw.plane_names.push_back("plane " + std::to_string(k));
        RawContour contour;
        contour.plane = k;
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        const double reach = std::sqrt(radius * radius - h * h);
        for (int i = 0; i < corners; ++i) {
            const double angle = 2 * std::numbers::pi * i / corners;
            raw.points.push_back(plane.to_space({reach * std::cos(angle), reach * std::sin(angle)}));
        }
        contour.point_count = static_cast<std::uint32_t>(corners);
        raw.contours.push_back(contour);
    }
    RunContext context;
    return std::move(reconcile_contours(fixtures::kept(raw), {}, context).value().kept);
}

// Planes through one axis, all contours through its two poles.
inline ContourSet turned(int planes, int corners) {
    RawContours raw;
    raw.structures.push_back({1, "ball", {}});
    for (int k = 0; k < planes; ++k) {
        const double turn = std::numbers::pi * k / planes;
        const Plane plane = make_plane({0, 0, 0}, {-std::sin(turn), std::cos(turn), 0});
        raw.planes.push_back(plane);
        raw.plane_names.push_back("plane " + std::to_string(k));
        RawContour contour;
        contour.plane = k;
        contour.first_point = static_cast<std::uint32_t>(raw.points.size());
        for (int i = 0; i < corners; ++i) {
            const double angle = 2 * std::numbers::pi * (i + 0.5) / corners,
                         across = radius * std::cos(angle);
            raw.points.push_back(
                {across * std::cos(turn), across * std::sin(turn), radius * std::sin(angle)});
        }
        contour.point_count = static_cast<std::uint32_t>(corners);
        raw.contours.push_back(contour);
    }
    RunContext context;
    return std::move(reconcile_contours(fixtures::kept(raw), {}, context).value().kept);
}

}  // namespace anatomesh::dense_plane_sets
