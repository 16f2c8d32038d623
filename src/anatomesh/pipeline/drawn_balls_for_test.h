// For tests: contours as a file gives them, of balls drawn on slices, one set for each way that sets are
// prepared.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "anatomesh/contour/model/raw_contours.h"

namespace anatomesh::fixtures {

struct DrawnBall {
    std::string name;
    Vec3 center;  // mm
    double radius_mm = 10;
    int points = 40;  // of a contour
};

struct DrawnSet {
    std::string name;
    RawContours raw;
    std::vector<std::string> priority;
};

inline void PrintTo(const DrawnSet& set, std::ostream* out) {
    *out << set.name;
}

class BallDrawer {
  public:
    explicit BallDrawer(std::vector<DrawnBall> balls) : balls_(std::move(balls)) {
        for (std::uint32_t b = 0; b < balls_.size(); ++b)
            raw_.structures.push_back({static_cast<std::int32_t>(b + 1), balls_[b].name, {200, 100, 50}});
    }

    // Circles in planes across the axis (0 x, 1 y, 2 z) at the places given. `grown`: their radii are so many
    // times what they are.
    void draw(int axis, const std::vector<double>& places, double grown = 1) {
        const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        const Vec3 normal = axes[axis], u = axes[(axis + 1) % 3], v = axes[(axis + 2) % 3];
        for (const double place : places) {
            for (std::uint32_t b = 0; b < balls_.size(); ++b) {
                const double height = place - dot(balls_[b].center, normal);
                const double square = balls_[b].radius_mm * balls_[b].radius_mm - height * height;
                if (square < 1) continue;
                add_circle(b, balls_[b].center + height * normal, grown * std::sqrt(square), u, v,
                           std::string(1, "xyz"[axis]) + " = " + std::to_string(place));
            }
        }
    }

    RawContours raw() const { return raw_; }

  private:
    void add_circle(std::uint32_t ball, Vec3 center, double r, Vec3 u, Vec3 v, const std::string& slice) {
        RawContour contour;
        contour.structure = ball;
        contour.slice = slice;
        contour.first_point = static_cast<std::uint32_t>(raw_.points.size());
        contour.point_count = static_cast<std::uint32_t>(balls_[ball].points);
        for (int i = 0; i < balls_[ball].points; ++i) {
            const double a = 2 * std::numbers::pi * i / balls_[ball].points;
            raw_.points.push_back(center + r * std::cos(a) * u + r * std::sin(a) * v);
        }
        raw_.contours.push_back(contour);
    }

    std::vector<DrawnBall> balls_;
    RawContours raw_;
};

inline std::vector<double> every(double step, double from, double to) {
    std::vector<double> places;
    for (double place = from; place <= to; place += step) places.push_back(place);
    return places;
}

// Two boxes with one wall, that of the second off it by what a text rounds away.
inline RawContours two_boxes() {
    RawContours raw;
    raw.structures = {{1, "left", {200, 100, 50}}, {2, "right", {50, 100, 200}}};
    constexpr int points = 8;          // of a side
    constexpr double rounded = 0.004;  // mm
    for (std::uint32_t box = 0; box < 2; ++box) {
        const double low = box == 0 ? -8 : rounded, high = box == 0 ? 0 : 8;
        const Vec3 corners[] = {{low, -6, 0}, {high, -6, 0}, {high, 6, 0}, {low, 6, 0}, {low, -6, 0}};
        for (const double z : every(2, -5, 5)) {
            RawContour contour;
            contour.structure = box;
            contour.slice = "z = " + std::to_string(z);
            contour.first_point = static_cast<std::uint32_t>(raw.points.size());
            contour.point_count = 4 * points;
            for (int side = 0; side < 4; ++side) {
                for (int i = 0; i < points; ++i)
                    raw.points.push_back(corners[side] +
                                         (1.0 * i / points) * (corners[side + 1] - corners[side]) +
                                         Vec3{0, 0, z});
            }
            raw.contours.push_back(contour);
        }
    }
    return raw;
}

// Parallel, crossing, overlapping with and without priority, nested with priority, thin walls, and
// walls in common.
inline std::vector<DrawnSet> drawn_sets() {
    const std::vector<double> axial = every(2.5, -8.75, 8.75);
    std::vector<DrawnSet> sets;
    const auto add = [&](const char* name, const BallDrawer& drawer, std::vector<std::string> priority = {}) {
        sets.push_back({name, drawer.raw(), std::move(priority)});
    };
    BallDrawer parallel({{"left", {-10, 0, 0}}, {"right", {10, 0, 0}}});
    parallel.draw(2, axial);
    add("parallel", parallel);

    BallDrawer crossing({{"left", {-10.5, 0, 0}}, {"right", {10.5, 0, 0}}});
    crossing.draw(2, axial);
    crossing.draw(1, {0.3}, 1.04);  // drawn larger than the others say
    add("crossing", crossing);

    BallDrawer overlapping({{"left", {-6, 0, 0}}, {"right", {6, 0, 0}}});
    overlapping.draw(2, axial);
    add("overlapping", overlapping);
    add("overlapping_first_right", overlapping, {"right"});

    BallDrawer nested({{"organ", {0, 0, 0}}, {"tumour", {2, 0, 0}, 4, 24}});
    nested.draw(2, axial);
    add("nested_first_tumour", nested, {"tumour"});

    BallDrawer crossing_priority({{"organ", {0, 0, 0}}, {"vessel", {9, 0, 0}, 5, 24}});
    crossing_priority.draw(2, axial);
    crossing_priority.draw(1, {0.3}, 1.02);
    add("crossing_first_vessel", crossing_priority, {"2"});

    BallDrawer walls({{"outer", {0, 0, 0}}, {"inner", {0, 0, 0}, 9}});  // half an edge apart
    walls.draw(2, axial);
    add("thin_walls", walls);
    sets.push_back({"shared_wall", two_boxes(), {}});
    return sets;
}

}  // namespace anatomesh::fixtures
