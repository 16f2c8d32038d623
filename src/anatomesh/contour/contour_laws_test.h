// For tests: the laws of a kept contour set, checked one by one without any of the code they are laws of.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/predicates.h"

namespace anatomesh {

inline std::vector<Vec2> in_plane(const ContourSet& set, const Contour& contour) {
    std::vector<Vec2> polygon;
    for (const Vec3& point : set.points_of(contour)) {
        polygon.push_back(set.slices[contour.slice].plane.to_plane(point));
    }
    return polygon;
}

// Positive when counter-clockwise seen along -normal.
inline double signed_area(const std::vector<Vec2>& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        twice += cross(polygon[i] - polygon[0], polygon[(i + 1) % polygon.size()] - polygon[0]);
    }
    return twice / 2;
}

inline double perimeter(const std::vector<Vec2>& polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i)
        sum += length(polygon[(i + 1) % polygon.size()] - polygon[i]);
    return sum;
}

// The area of a structure's drawn region in a slice; outer contours count positive, holes negative.
inline double region_area(const ContourSet& set, std::uint32_t slice, std::uint32_t structure) {
    double area = 0;
    for (const Contour& contour : set.contours_of(set.slices[slice])) {
        if (contour.structure == structure) area += signed_area(in_plane(set, contour));
    }
    return area;
}

inline bool encloses(const std::vector<Vec2>& polygon, Vec2 p) {
    bool inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        if ((a.y > p.y) == (b.y > p.y)) continue;
        if (orient2d(a, b, p) == (b.y > a.y ? 1 : -1)) inside = !inside;
    }
    return inside;
}

inline bool on_segment(Vec2 p, Vec2 a, Vec2 b) {
    return orient2d(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
           std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}

// Equal points count as no meeting: contours of an exclusive set share them.
inline bool meet_apart_from_ends(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    if (orient2d(a, b, c) * orient2d(a, b, d) < 0 && orient2d(c, d, a) * orient2d(c, d, b) < 0) return true;
    const auto touches = [](Vec2 p, Vec2 q, Vec2 r) { return p != q && p != r && on_segment(p, q, r); };
    return touches(c, a, b) || touches(d, a, b) || touches(a, c, d) || touches(b, c, d);
}

inline double distance_to_polygon(Vec2 p, const std::vector<Vec2>& polygon) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 a = polygon[i], ab = polygon[(i + 1) % polygon.size()] - a;
        const double t = std::clamp(dot(p - a, ab) / squared_length(ab), 0.0, 1.0);
        least = std::min(least, length(p - a - t * ab));
    }
    return least;
}

// No two segments of the slice meet but in common end points, and no polygon passes a point twice.
inline void expect_no_crossing(const ContourSet& set, const Slice& slice) {
    struct Segment {
        Vec2 a, b;
    };
    std::vector<Segment> segments;
    for (const Contour& contour : set.contours_of(slice)) {
        const std::vector<Vec2> polygon = in_plane(set, contour);
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            segments.push_back({polygon[i], polygon[(i + 1) % polygon.size()]});
        }
        std::vector<Vec3> points(set.points_of(contour).begin(), set.points_of(contour).end());
        std::sort(points.begin(), points.end(), LexicographicLess{});
        EXPECT_EQ(std::adjacent_find(points.begin(), points.end()), points.end())
            << "a contour of slice " << slice.name << " passes a point twice";
    }
    const auto left = [](const Segment& s) { return std::min(s.a.x, s.b.x); };
    const auto right = [](const Segment& s) { return std::max(s.a.x, s.b.x); };
    std::sort(segments.begin(), segments.end(),
              [&](const Segment& s, const Segment& t) { return left(s) < left(t); });
    std::size_t crossings = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        for (std::size_t j = i + 1; j < segments.size() && left(segments[j]) <= right(segments[i]); ++j) {
            crossings += meet_apart_from_ends(segments[i].a, segments[i].b, segments[j].a, segments[j].b);
        }
    }
    EXPECT_EQ(crossings, 0u) << "in slice " << slice.name;
}

// Outer contours counter-clockwise, holes clockwise, by the depth of nesting in the same structure.
inline void expect_orientation(const ContourSet& set, const Slice& slice) {
    for (const Contour& contour : set.contours_of(slice)) {
        const std::vector<Vec2> polygon = in_plane(set, contour);
        int depth = 0;
        for (const Contour& other : set.contours_of(slice)) {
            if (&other == &contour || other.structure != contour.structure) continue;
            depth += encloses(in_plane(set, other), polygon.front());
        }
        EXPECT_GT(signed_area(polygon) * (depth % 2 == 0 ? 1 : -1), 0) << "in slice " << slice.name;
    }
}

inline void expect_order(const ContourSet& set) {
    std::uint32_t next = 0, next_point = 0;
    for (std::size_t s = 0; s < set.slices.size(); ++s) {
        const Slice& slice = set.slices[s];
        EXPECT_EQ(slice.first_contour, next);
        next += slice.contour_count;
        if (s > 0) {
            EXPECT_GT(dot(slice.plane.origin - set.slices[s - 1].plane.origin, slice.plane.normal), 0);
        }
        const Contour* before = nullptr;
        for (const Contour& contour : set.contours_of(slice)) {
            const auto points = set.points_of(contour);
            EXPECT_EQ(contour.slice, s);
            EXPECT_EQ(contour.first_point, next_point);
            next_point += contour.point_count;
            ASSERT_GE(points.size(), 3u);
            EXPECT_EQ(std::min_element(points.begin(), points.end(), LexicographicLess{}), points.begin());
            if (before) {
                EXPECT_TRUE(before->structure < contour.structure ||
                            (before->structure == contour.structure &&
                             lexicographic_less(set.points_of(*before).front(), points.front())));
            }
            before = &contour;
        }
    }
    EXPECT_EQ(next, set.contours.size());
    EXPECT_EQ(next_point, set.points.size());
}

inline void expect_kept_contour_set(const ContourSet& set, bool exclusive = true) {
    expect_order(set);
    for (const Slice& slice : set.slices) {
        if (exclusive) expect_no_crossing(set, slice);
        expect_orientation(set, slice);
        for (const Contour& contour : set.contours_of(slice)) {
            for (const Vec3& point : set.points_of(contour)) {
                EXPECT_NEAR(slice.plane.signed_distance(point), 0, 1e-9 * (1 + length(point)));
            }
        }
    }
}

}  // namespace anatomesh
