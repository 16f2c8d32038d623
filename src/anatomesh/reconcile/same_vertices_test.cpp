#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "anatomesh/reconcile/reconcile.h"

namespace anatomesh::same_vertices_test {
namespace {

struct Ellipsoid {
    Vec3 half_axes, centre;
};

// Section of an ellipsoid: centre + cos t * first + sin t * second.
struct Section {
    Vec3 centre, first, second;
    Vec3 at(double t) const { return centre + std::cos(t) * first + std::sin(t) * second; }
    double speed(double t) const { return length(-std::sin(t) * first + std::cos(t) * second); }
};

bool cut(const Ellipsoid& solid, const Plane& plane, Section& section) {
    const Vec3 h = solid.half_axes, o = plane.origin - solid.centre;
    const auto scaled = [&](Vec3 p) { return Vec3{p.x / h.x, p.y / h.y, p.z / h.z}; };
    const Vec3 u = scaled(plane.u), v = scaled(plane.v), w = scaled(o);
    const double a = dot(u, u), b = dot(u, v), c = dot(v, v), d = dot(w, u), e = dot(w, v);
    const double determinant = a * c - b * b;
    const double x = (b * e - c * d) / determinant, y = (b * d - a * e) / determinant;
    const double rest = 1 - dot(w, w) - d * x - e * y;
    if (rest <= 0.05) return false;
    // By Cholesky's factors of the quadratic form.
    const double l = std::sqrt(a), m = b / l, n = std::sqrt(c - m * m), r = std::sqrt(rest);
    section.centre = plane.origin + x * plane.u + y * plane.v;
    section.first = (r / l) * plane.u;
    section.second = (r / n) * (plane.v - (m / l) * plane.u);
    return true;
}

// Vertices `apart` mm beside every line in which another plane crosses, this way or that, and others between.
std::vector<double> places(const Section& section, const std::vector<Plane>& planes, std::size_t own,
                           double apart) {
    std::vector<double> crossings;
    for (std::size_t k = 0; k < planes.size(); ++k) {
        const double x = dot(planes[k].normal, section.first), y = dot(planes[k].normal, section.second),
                     d = planes[k].signed_distance(section.centre), size = std::hypot(x, y);
        if (k == own || size < 1e-9 || std::abs(d) >= 0.98 * size) continue;
        for (const double sign : {1.0, -1.0}) {
            double t = std::atan2(y, x) + sign * std::acos(-d / size);
            t += (own % 2 == 0 ? 0.5 : -0.5) * apart / section.speed(t);
            crossings.push_back(t - 2 * std::numbers::pi * std::floor(t / (2 * std::numbers::pi)));
        }
    }
    std::sort(crossings.begin(), crossings.end());
    const auto is_near = [&](double s, double t) { return length(section.at(s) - section.at(t)) < 0.05; };
    crossings.erase(std::unique(crossings.begin(), crossings.end(), is_near), crossings.end());
    if (crossings.size() > 1 && is_near(crossings.front(), crossings.back())) crossings.pop_back();
    if (crossings.empty()) crossings.push_back(0.1);
    std::vector<double> all;
    for (std::size_t n = 0; n < crossings.size(); ++n) {
        const double from = crossings[n],
                     to = n + 1 < crossings.size() ? crossings[n + 1] : crossings[0] + 2 * std::numbers::pi;
        const double way = (to - from) * section.speed(0.5 * (from + to));
        const int steps = std::max(1, static_cast<int>(way / 3));
        for (int k = 0; k < steps; ++k) all.push_back(from + (to - from) * k / steps);
    }
    return all;
}

ContourSet drawn(const std::vector<Ellipsoid>& solids, const std::vector<Plane>& planes, double apart,
                 double rounding) {
    ContourSet set;
    set.source = "solids";
    for (std::size_t s = 0; s < solids.size(); ++s)
        set.structures.push_back({static_cast<int>(s) + 1, "solid", {200, 200, 200}});
    for (std::size_t k = 0; k < planes.size(); ++k) {
        const auto first = static_cast<std::uint32_t>(set.contours.size());
        for (std::uint32_t s = 0; s < solids.size(); ++s) {
            Section section;
            if (!cut(solids[s], planes[k], section)) continue;
            std::vector<Vec3> points;
            for (const double t : places(section, planes, k, apart)) {
                Vec3 p = section.at(t);
                if (rounding > 0) {
                    p = {std::round(p.x / rounding) * rounding, std::round(p.y / rounding) * rounding,
                         std::round(p.z / rounding) * rounding};
                    p = p - planes[k].signed_distance(p) * planes[k].normal;
                }
                points.push_back(p);
            }
            std::rotate(points.begin(), std::min_element(points.begin(), points.end(), LexicographicLess{}),
                        points.end());
            set.contours.push_back({s, static_cast<std::uint32_t>(set.slices.size()),
                                    static_cast<std::uint32_t>(set.points.size()),
                                    static_cast<std::uint32_t>(points.size())});
            set.points.insert(set.points.end(), points.begin(), points.end());
        }
        const auto count = static_cast<std::uint32_t>(set.contours.size()) - first;
        if (count > 0) set.slices.push_back({planes[k], first, count, std::to_string(k)});
    }
    return set;
}

std::vector<Plane> stack(Vec3 normal, std::initializer_list<double> heights) {
    std::vector<Plane> planes;
    for (const double height : heights)
        planes.push_back(make_plane(height * normalized(normal), normalized(normal)));
    return planes;
}

std::vector<Plane> fan(int count, Vec3 through) {
    std::vector<Plane> planes;
    for (int k = 0; k < count; ++k) {
        const double angle = std::numbers::pi * k / count;
        planes.push_back(make_plane(through, {std::cos(angle), std::sin(angle), 0}));
    }
    return planes;
}

std::vector<Plane> together(std::initializer_list<std::vector<Plane>> all) {
    std::vector<Plane> planes;
    for (const std::vector<Plane>& some : all) planes.insert(planes.end(), some.begin(), some.end());
    return planes;
}

const std::vector<std::pair<std::string, std::vector<Plane>>>& arrangements() {
    static const std::vector<std::pair<std::string, std::vector<Plane>>> all{
        {"three at right angles",
         together({stack({1, 0, 0}, {0}), stack({0, 1, 0}, {0}), stack({0, 0, 1}, {0})})},
        {"a stack across a stack",
         together({stack({0, 0, 1}, {-23, -15, -7, 1, 9, 17}), stack({1, 0, 0}, {-18, -8, 2, 12})})},
        {"oblique stacks",
         together({stack({0.2, 0.1, 1}, {-20, -10, 0, 10, 20}), stack({1, 0.3, -0.1}, {-16, -5, 6, 17})})},
        {"a fan", fan(9, {0, 0, 0})},
        {"a fan beside the middle", fan(8, {5, 3, 0})},
        {"a fan and a plane across", together({fan(7, {0, 0, 0}), stack({0, 0, 1}, {3})})}};
    return all;
}

const std::vector<std::pair<std::string, std::vector<Ellipsoid>>>& solids() {
    static const std::vector<std::pair<std::string, std::vector<Ellipsoid>>> all{
        {"a ball", {{{30, 30, 30}, {0, 0, 0}}}},
        {"an ellipsoid", {{{27, 21, 36}, {1, -2, 0.5}}}},
        {"two nested", {{{30, 30, 30}, {0, 0, 0}}, {{15, 18, 21}, {2, 1, -1}}}}};
    return all;
}

ContourSet kept(const ContourSet& set) {
    RunContext context;
    Result<ReconcileResult> result = reconcile_contours(set, {}, context);
    EXPECT_TRUE(result.ok()) << to_line(result.error());
    EXPECT_EQ(result.value().stats.difference_after_mm, 0);
    return std::move(result).value().kept;
}

double shortest_segment(const ContourSet& set) {
    double least = 1e9;
    for (const Contour& contour : set.contours) {
        const auto points = set.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n)
            least = std::min(least, length(points[(n + 1) % points.size()] - points[n]));
    }
    return least;
}

double farthest_from(const ContourSet& set, const ContourSet& other) {
    double most = 0;
    for (const Vec3& p : set.points) {
        double least = 1e9;
        for (const Vec3& q : other.points) least = std::min(least, length(p - q));
        most = std::max(most, least);
    }
    return most;
}

// Calls `check` with the contours as they are meant, and as they are drawn, up to `off_mm` off.
void for_each_member(
    const std::function<void(const ContourSet& meant, const ContourSet& drawn, double off_mm)>& check) {
    for (const auto& [arrangement, planes] : arrangements()) {
        for (const auto& [name, solid] : solids()) {
            SCOPED_TRACE(arrangement + ", " + name);
            const ContourSet meant = kept(drawn(solid, planes, 0, 0));
            for (const double apart : {1e-9, 3e-7, 1e-5, 1e-4, 1e-3, 1e-2}) {
                SCOPED_TRACE(apart);
                check(meant, drawn(solid, planes, apart, 0), apart);
            }
            for (const double rounding : {1e-4, 1e-3}) {
                SCOPED_TRACE(rounding);
                check(meant, drawn(solid, planes, 0, rounding), 4 * rounding);
            }
        }
    }
}

// A file in metres, or of few decimals, leaves vertices of slices that were one beside each other.
TEST(SameVertices, what_rounding_set_apart_where_slices_cross_is_one_vertex_again) {
    std::size_t members = 0;
    for_each_member([&](const ContourSet& meant, const ContourSet& drawn, double off_mm) {
        const ContourSet result = kept(drawn);
        EXPECT_EQ(result.points.size(), meant.points.size());
        EXPECT_GE(shortest_segment(result), 0.9 * shortest_segment(meant));
        EXPECT_LE(farthest_from(result, meant), off_mm + 1e-6);
        EXPECT_LE(farthest_from(meant, result), off_mm + 1e-6);
        ++members;
    });
    EXPECT_GE(members, 50u);
}

}  // namespace
}  // namespace anatomesh::same_vertices_test
