// Tubes drawn on planes normal to their paths: arches, helices, random ones, and branches.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/field/field_fixtures.h"
#include "anatomesh/geom/plane.h"

namespace anatomesh::fixtures {

// A point of a path and the direction there.
struct PathPoint {
    Vec3 at, along;
};

struct Path {
    std::function<PathPoint(double)> at;  // by the way from its start, mm
    double length = 0;
};

inline Path straight_path(Vec3 from, Vec3 to) {
    const double length = anatomesh::length(to - from);
    const Vec3 along = (1 / length) * (to - from);
    return {[=](double s) { return PathPoint{from + s * along, along}; }, length};
}

// Two straight legs, and a bend by `angle` between them.
inline Path arch_path(double first_leg, double last_leg, double bend, double angle = std::numbers::pi) {
    const double turn = bend * angle;
    const auto at = [=](double s) -> PathPoint {
        if (s < first_leg) return {{-bend, 0, s}, {0, 0, 1}};
        const double a = std::min(s - first_leg, turn) / bend;
        const PathPoint on_bend{{-bend * std::cos(a), 0, first_leg + bend * std::sin(a)},
                                {std::sin(a), 0, std::cos(a)}};
        return {on_bend.at + std::max(0.0, s - first_leg - turn) * on_bend.along, on_bend.along};
    };
    return {at, first_leg + turn + last_leg};
}

inline Path helix_path(double radius, double pitch, double turns) {
    const double rise = pitch / (2 * std::numbers::pi), speed = std::hypot(radius, rise);
    const auto at = [=](double s) -> PathPoint {
        const double a = s / speed;
        return {{radius * std::cos(a), radius * std::sin(a), rise * a},
                (1 / speed) * Vec3{-radius * std::sin(a), radius * std::cos(a), rise}};
    };
    return {at, turns * 2 * std::numbers::pi * speed};
}

// `radius`: by the way from the start. The slices lie in the middles of as many equal parts of the path as make about
// `spacing`; frames are turned at random, and half of the normals run against the path.
struct Tube {
    Path path;
    std::function<double(double)> radius;
    double spacing = 4;
    std::uint32_t structure = 0;
};

inline constexpr int corners_of_tube = 40;

inline std::size_t slices_of(const Tube& tube) {
    return static_cast<std::size_t>(std::max(2.0, std::round(tube.path.length / tube.spacing)));
}

inline void draw(const Tube& tube, std::mt19937& random, SetBuilder& builder) {
    const std::size_t count = slices_of(tube);
    for (std::size_t n = 0; n < count; ++n) {
        const double s = (static_cast<double>(n) + 0.5) * tube.path.length / static_cast<double>(count);
        const PathPoint point = tube.path.at(s);
        const bool against = random() % 2 == 0;
        builder.slice(make_plane(point.at, (against ? -1.0 : 1.0) * point.along));
        builder.ring(tube.structure,
                     circle({}, tube.radius(s), corners_of_tube, static_cast<double>(random() % 100)));
    }
}

inline ContourSet drawn(const std::vector<Tube>& tubes, unsigned seed = 1) {
    std::mt19937 random(seed);
    SetBuilder builder;
    for (const Tube& tube : tubes) draw(tube, random, builder);
    return builder.set;
}

inline Vec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return normalized(Vec3{normal(random), normal(random), normal(random)});
}

// As drawn(), on planes that were set by eye: moved by so much, and turned by so many degrees, each in a direction of
// its own.
inline ContourSet drawn_by_eye(const Tube& tube, double moved_mm, double turned_degrees, unsigned seed) {
    std::mt19937 random(seed);
    SetBuilder builder;
    const std::size_t count = slices_of(tube);
    const double turned = turned_degrees * std::numbers::pi / 180;
    for (std::size_t n = 0; n < count; ++n) {
        const double s = (static_cast<double>(n) + 0.5) * tube.path.length / static_cast<double>(count);
        const PathPoint point = tube.path.at(s);
        const Vec3 way = random_direction(random);
        const Vec3 across = normalized(way - dot(way, point.along) * point.along);
        const bool against = random() % 2 == 0;
        builder.slice(make_plane(
            point.at + moved_mm * random_direction(random),
            (against ? -1.0 : 1.0) * (std::cos(turned) * point.along + std::sin(turned) * across)));
        builder.ring(tube.structure,
                     circle({}, tube.radius(s), corners_of_tube, static_cast<double>(random() % 100)));
    }
    return builder.set;
}

// Pappus: where the path runs through the middles of the outlines, bends change nothing.
inline double volume_of(const Tube& tube) {
    const double factor = 0.5 * corners_of_tube * std::sin(2 * std::numbers::pi / corners_of_tube);
    double sum = 0;
    constexpr int steps = 2000;
    for (int n = 0; n < steps; ++n) {
        const double radius = tube.radius((n + 0.5) * tube.path.length / steps);
        sum += factor * radius * radius;
    }
    return sum * tube.path.length / steps;
}

struct NamedTube {
    std::string name;
    Tube tube;
};

// Legs of any length, spacings of 2 to 10 mm, bends of 60 to 180 degrees, helices, aneurysms.
inline std::vector<NamedTube> families_of_tubes() {
    std::vector<NamedTube> made;
    const auto constant = [](double radius) { return [radius](double) { return radius; }; };
    for (const auto& [first, last] :
         {std::pair{60.0, 100.0}, {60.0, 60.0}, {20.0, 100.0}, {0.0, 80.0}, {40.0, 160.0}}) {
        for (const double spacing : {2.0, 4.0, 5.0, 8.0, 10.0})
            made.push_back({"arch", {arch_path(first, last, 30), constant(12), spacing}});
    }
    for (const double angle : {60.0, 90.0, 130.0, 160.0}) {
        for (const auto& [bend, radius] : {std::pair{20.0, 6.0}, {40.0, 15.0}, {20.0, 8.0}})
            made.push_back(
                {"bend", {arch_path(50, 70, bend, angle * std::numbers::pi / 180), constant(radius), 4}});
    }
    for (const double spacing : {2.5, 5.0, 8.0}) {
        made.push_back({"helix", {helix_path(25, 30, 2), constant(6), spacing}});
        made.push_back({"helix", {helix_path(15, 25, 3), constant(5), spacing}});
        made.push_back({"helix", {helix_path(40, 40, 1.5), constant(10), spacing}});
    }
    for (const double spacing : {2.0, 4.0, 6.0}) {
        for (const double middle : {40.0, 110.0, 200.0}) {
            const auto sac = [=](double s) { return 8 + 12 * std::exp(-(s - middle) * (s - middle) / 225); };
            made.push_back({"aneurysm", {arch_path(60, 100, 30), sac, spacing}});
        }
    }
    return made;
}

// Arches, helices, bends and straight tubes of radius 8 to 15 mm, their slices 4 to 10 mm apart and mostly near to each
// other.
inline std::vector<NamedTube> random_tubes(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<NamedTube> made;
    for (std::size_t n = 0; n < count; ++n) {
        const double close = unit(random), spacing = 4 + 6 * close * close, radius = 8 + 7 * unit(random);
        const double a = unit(random), b = unit(random), c = unit(random);
        NamedTube tube{"arch", {arch_path(20 + 60 * a, 20 + 80 * b, 28 + 12 * c), {}, spacing}};
        if (n % 4 == 1) tube = {"helix", {helix_path(35 + 10 * a, 45 + 15 * b, 1 + c), {}, spacing}};
        if (n % 4 == 2)
            tube = {"bend",
                    {arch_path(50, 70, 30 + 15 * a, std::numbers::pi * (0.4 + 0.5 * b)), {}, spacing}};
        if (n % 4 == 3) tube = {"straight", {straight_path({0, 0, 0}, {0, 0, 100 + 60 * a}), {}, spacing}};
        tube.tube.radius = [radius](double) { return radius; };
        made.push_back(std::move(tube));
    }
    return made;
}

}  // namespace anatomesh::fixtures
