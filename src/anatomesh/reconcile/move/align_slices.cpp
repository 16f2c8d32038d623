#include "anatomesh/reconcile/move/align_slices.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/reconcile/move/contour_graph.h"

namespace anatomesh {

namespace {

// A gap between ends below this is noise of drawing. [mm; > 0; M 2026-11, set not recorded]
constexpr double least_bound_mm = 1;
// A whole shift is pulled back by this weight, beside some 0.5 for every end. [1; > 0; M 2026-11, set not
// recorded]
constexpr double pull_to_place = 0.02;
// Contours that run nearly along the line say nothing about shifts. [1, sine; 0 to 1; M 2026-11, set not
// recorded]
constexpr double least_crossing_sine = 0.2;
// Huber's bound is so many medians. [1; > 1; M 2026-11, set not recorded]
constexpr double huber_medians = 1.5;
// Conjugate gradients end after so many steps, wherever they are. [steps; >= 1; B]
constexpr int most_shift_steps = 200;
// The search for a common translation ends after so many steps, wherever it is. [steps; >= 1; B]
constexpr int most_translation_steps = 100;
// Shorter movements get no larger weight in the median. [mm; > 0; D]
constexpr double least_length_mm = 1e-4;
// Directions in which no slice moves get this stiffness, so that the equations have one solution. [1; > 0; D]
constexpr double least_stiffness = 1e-9;
// A common translation is taken off only if at most this share of the movement is left. [1; 0 to 1; M
// 2026-11, set not recorded]
constexpr double left_share = 0.75;

// An equation contributes weight * (gap + to_a . shift of a - to_b . shift of b)^2.
struct Equation {
    std::uint32_t a = 0, b = 0;
    Vec2 to_a, to_b;
    double gap = 0, weight = 0;
};

std::vector<Equation> equations_of(const ContourSet& set, std::span<const LineComparison> comparisons) {
    std::vector<Equation> equations;
    for (const LineComparison& comparison : comparisons) {
        const Vec3 along = comparison.line.direction;
        const Plane &plane_a = set.slices[comparison.a].plane, &plane_b = set.slices[comparison.b].plane;
        const Vec2 along_a{dot(along, plane_a.u), dot(along, plane_a.v)},
            along_b{dot(along, plane_b.u), dot(along, plane_b.v)};
        for (const auto& [i, j] : comparison.matching.matched) {
            const Vec2 normal_a = contour_normal(set, comparison.endpoints_a[i], measuring_chord_mm),
                       normal_b = contour_normal(set, comparison.endpoints_b[j], measuring_chord_mm);
            const double sine_a = dot(normal_a, along_a), sine_b = dot(normal_b, along_b);
            if (std::abs(sine_a) < least_crossing_sine || std::abs(sine_b) < least_crossing_sine) continue;
            equations.push_back({comparison.a, comparison.b, (1 / sine_a) * normal_a, (1 / sine_b) * normal_b,
                                 comparison.endpoints_a[i].t - comparison.endpoints_b[j].t,
                                 1 / (1 / (sine_a * sine_a) + 1 / (sine_b * sine_b))});
        }
    }
    return equations;
}

// Applies Huber's weights about the median gap across the contours.
void reweigh(std::vector<Equation>& equations) {
    std::vector<double> gaps;
    for (const Equation& e : equations) gaps.push_back(std::abs(e.gap) * std::sqrt(e.weight));
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    const double bound = std::max(huber_medians * *middle, least_bound_mm);
    for (Equation& e : equations) {
        const double gap = std::abs(e.gap) * std::sqrt(e.weight);
        if (gap > bound) e.weight *= bound / gap;
    }
}

}  // namespace

std::vector<Vec2> estimate_shifts(const ContourSet& set, std::span<const LineComparison> comparisons,
                                  std::span<const Vec2> shifted) {
    std::vector<Vec2> shifts(set.slices.size());
    std::vector<Equation> equations = equations_of(set, comparisons);
    if (equations.empty()) return shifts;
    reweigh(equations);
    // Carries the equations' values times their weights back to the slices.
    const auto spread = [&](const std::vector<Vec2>& x, auto&& value_of, std::vector<Vec2>& out) {
        out.assign(x.size(), {});
        for (const Equation& e : equations) {
            const double value = e.weight * value_of(e, x);
            out[e.a] = out[e.a] + value * e.to_a;
            out[e.b] = out[e.b] - value * e.to_b;
        }
    };
    const auto linear = [](const Equation& e, const std::vector<Vec2>& x) {
        return dot(e.to_a, x[e.a]) - dot(e.to_b, x[e.b]);
    };
    const auto product = [](const std::vector<Vec2>& x, const std::vector<Vec2>& y) {
        double sum = 0;
        for (std::size_t i = 0; i < x.size(); ++i) sum += dot(x[i], y[i]);
        return sum;
    };
    std::vector<Vec2> residual, direction, image;
    spread(
        shifts, [](const Equation& e, const std::vector<Vec2>&) { return -e.gap; }, residual);
    for (std::size_t i = 0; i < shifts.size(); ++i) residual[i] = residual[i] - pull_to_place * shifted[i];
    direction = residual;
    double square = product(residual, residual);
    const double enough = 1e-16 * square;
    for (int step = 0; step < most_shift_steps && square > enough; ++step) {
        spread(direction, linear, image);
        for (std::size_t i = 0; i < image.size(); ++i) image[i] = image[i] + pull_to_place * direction[i];
        const double curvature = product(direction, image);
        if (!(curvature > 1e-12 * product(direction, direction))) break;
        const double length = square / curvature;
        for (std::size_t i = 0; i < shifts.size(); ++i) {
            shifts[i] = shifts[i] + length * direction[i];
            residual[i] = residual[i] - length * image[i];
        }
        const double next = product(residual, residual), ratio = next / square;
        square = next;
        for (std::size_t i = 0; i < shifts.size(); ++i) direction[i] = residual[i] + ratio * direction[i];
    }
    return shifts;
}

Vec3 common_translation(const ContourSet& set, std::span<const Vec2> shifts) {
    const auto left_of = [&](std::size_t s, Vec3 translation) {
        const Plane& plane = set.slices[s].plane;
        return shifts[s] - Vec2{dot(translation, plane.u), dot(translation, plane.v)};
    };
    const auto movement = [&](Vec3 translation) {
        double sum = 0;
        for (std::size_t s = 0; s < shifts.size(); ++s) sum += length(left_of(s, translation));
        return sum;
    };
    Vec3 translation;
    for (int step = 0; step < most_translation_steps; ++step) {
        // These are the rows of the normal equations, and their right side.
        std::array<Vec3, 3> rows{};
        Vec3 right;
        double weights = 0;
        for (std::size_t s = 0; s < shifts.size(); ++s) {
            const Plane& plane = set.slices[s].plane;
            const double weight = 1 / std::max(length(left_of(s, translation)), least_length_mm);
            weights += weight;
            for (const Vec3& axis : {plane.u, plane.v}) {
                rows[0] += weight * axis.x * axis, rows[1] += weight * axis.y * axis;
                rows[2] += weight * axis.z * axis;
            }
            right += weight * (shifts[s].x * plane.u + shifts[s].y * plane.v);
        }
        rows[0].x += least_stiffness * weights, rows[1].y += least_stiffness * weights;
        rows[2].z += least_stiffness * weights;
        // This is Cramer's rule; the matrix is symmetric, so its rows are its columns.
        const Vec3 across = cross(rows[1], rows[2]);
        const double determinant = dot(rows[0], across);
        if (!(determinant > 0)) break;
        translation = (1 / determinant) * Vec3{dot(right, across), dot(rows[0], cross(right, rows[2])),
                                               dot(rows[0], cross(rows[1], right))};
    }
    return movement(translation) <= left_share * movement({}) ? translation : Vec3{};
}

}  // namespace anatomesh
