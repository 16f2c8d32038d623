// For tests: random planes, nested rings and strokes, and laws of drawings that use none of the code they are laws of.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "anatomesh/contour/overlay/even_odd_area.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/live/draw/area/structure_rings.h"

namespace anatomesh::draw_fixtures {

using Random = std::mt19937;
using Polygon = std::vector<Vec2>;

inline double uniform(Random& random, double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

inline int whole(Random& random, int low, int high) {
    return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
}

inline Plane random_plane(Random& random) {
    if (random() % 4 == 0) return make_plane({0, 0, uniform(random, -100, 100)}, {0, 0, 1});
    const auto number = [&] { return uniform(random, -1, 1); };
    return make_plane({200 * number(), 200 * number(), 200 * number()}, {number(), number(), number() + 1.5});
}

inline Polygon circle(Vec2 centre, double radius, int points, double from = 0) {
    Polygon polygon;
    for (int n = 0; n < points; ++n) {
        const double angle = from + 2 * std::numbers::pi * n / points;
        polygon.push_back(centre + radius * Vec2{std::cos(angle), std::sin(angle)});
    }
    return polygon;
}

// A polygon with one vertex a direction, at 0.75 to 1 of the radius.
inline Polygon random_star(Random& random, Vec2 centre, double radius) {
    Polygon polygon = circle(centre, radius, whole(random, 5, 80), uniform(random, 0, 6));
    for (Vec2& p : polygon) p = centre + uniform(random, 0.75, 1) * (p - centre);
    if (random() % 2) std::reverse(polygon.begin(), polygon.end());
    return polygon;
}

inline StructureRings rings_of(const std::vector<Polygon>& polygons, const Plane& plane) {
    std::vector<std::vector<Vec3>> in_space;
    for (const Polygon& polygon : polygons) {
        std::vector<Vec3>& points = in_space.emplace_back();
        for (const Vec2 p : polygon) points.push_back(plane.to_space(p));
    }
    Result<StructureRings> made = make_structure_rings(in_space, plane);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : to_line(made.error()));
    return made.ok() ? made.value() : StructureRings{plane, {}};
}

// Parts side by side; in each one a hole, in that an island and so on, to a random depth; the rings are shuffled.
inline StructureRings random_rings(Random& random, const Plane& plane) {
    std::vector<Polygon> polygons;
    const int parts = whole(random, 1, 4);
    for (int part = 0; part < parts; ++part) {
        const Vec2 centre{60.0 * (part % 2), 60.0 * (part / 2)};
        const int depth = whole(random, 1, 4);
        double radius = uniform(random, 15, 28);
        for (int level = 0; level < depth; ++level, radius *= 0.55) {
            polygons.push_back(random_star(random, centre, radius));
        }
    }
    std::shuffle(polygons.begin(), polygons.end(), random);
    return rings_of(polygons, plane);
}

// A polygon that crosses itself as a rule.
inline Polygon random_scrawl(Random& random) {
    Polygon polygon;
    const Vec2 centre{uniform(random, -20, 80), uniform(random, -20, 80)};
    const double reach = uniform(random, 3, 40);
    const int points = whole(random, 3, 20);
    for (int n = 0; n < points; ++n) {
        polygon.push_back(centre + Vec2{uniform(random, -reach, reach), uniform(random, -reach, reach)});
    }
    return polygon;
}

// A path of a hand: steps of one length whose direction drifts.
inline Polygon random_path(Random& random, Vec2 start, int steps, double step, double drift) {
    Polygon path{start};
    double direction = uniform(random, 0, 6.28), turn = 0;
    for (int n = 0; n < steps; ++n) {
        turn = 0.9 * turn + uniform(random, -drift, drift);
        direction += turn;
        path.push_back(path.back() + step * Vec2{std::cos(direction), std::sin(direction)});
    }
    return path;
}

// Exact, by the rays towards +x.
inline bool encloses(std::span<const Vec2> polygon, Vec2 p) {
    bool inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        if (orient2d(a, b, p) == (b.y > a.y ? 1 : -1)) inside = !inside;
    }
    return inside;
}

inline bool encloses(std::span<const Ring> rings, Vec2 p) {
    bool inside = false;
    for (const Ring& ring : rings) inside ^= encloses(ring.at, p);
    return inside;
}

inline double distance_to_rings(std::span<const Ring> rings, Vec2 p) {
    double least = 1e300;
    for (const Ring& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            least = std::min(least, distance_to_segment(p, ring.at[i], ring.at[(i + 1) % ring.size()]));
        }
    }
    return least;
}

inline double distance_to_path(std::span<const Vec2> path, Vec2 p) {
    double least = path.size() == 1 ? length(p - path[0]) : 1e300;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        least = std::min(least, distance_to_segment(p, path[i], path[i + 1]));
    }
    return least;
}

// The area of the even-odd interior, from the segments alone.
inline double area_of(std::span<const Ring> rings) {
    std::vector<Segment2> segments;
    Box2 box;
    for (const Ring& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            segments.push_back({ring.at[i], ring.at[(i + 1) % ring.size()]});
            box.extend(ring.at[i]);
        }
    }
    return segments.empty() ? 0 : even_odd_area(segments, box.grown(1));
}

inline double area_of(const StructureRings& drawn) {
    return area_of(drawn.rings);
}

inline void expect_sound(const StructureRings& drawn) {
    const Status sound = check_structure_rings(drawn);
    EXPECT_TRUE(sound.ok()) << to_line(sound.error());
    for (const Ring& ring : drawn.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            ASSERT_EQ(ring.at[i], drawn.plane.to_plane(ring.points[i]));
        }
    }
}

inline bool same_bytes(const StructureRings& a, const StructureRings& b) {
    if (a.rings.size() != b.rings.size()) return false;
    for (std::size_t r = 0; r < a.rings.size(); ++r) {
        if (a.rings[r].points != b.rings[r].points || a.rings[r].at != b.rings[r].at) return false;
    }
    return true;
}

// Whether the points stand in the polygon one after the other, in this direction.
inline bool has_stretch(const std::vector<Vec3>& polygon, std::span<const Vec3> stretch) {
    const std::size_t n = polygon.size();
    for (std::size_t start = 0; start < n; ++start) {
        std::size_t k = 0;
        while (k < stretch.size() && k < n && polygon[(start + k) % n] == stretch[k]) ++k;
        if (k == stretch.size()) return true;
    }
    return false;
}

}  // namespace anatomesh::draw_fixtures
