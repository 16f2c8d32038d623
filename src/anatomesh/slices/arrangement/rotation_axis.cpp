#include "anatomesh/slices/arrangement/rotation_axis.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "anatomesh/geom/point_scatter.h"

namespace anatomesh {

namespace {

// An axis and a distance from it fit fewer planes by chance.
// [planes; >= 5; M 2026-11 planes beside their axis]
constexpr std::size_t fewest_beside = 8;
// Planes beside an axis lean by no more against the next one, 60 degrees: over wider gaps a distance from the
// axis says nothing. [rad; 0 to pi / 2; M 2026-11 planes beside their axis]
constexpr double widest_beside = std::numbers::pi / 3;
// A fit beside the axis must leave no more of the squares that the fit through it leaves, a quarter of the
// distances: else the simpler fit holds. [1; 0 to 1; M 2026-11 planes beside their axis]
constexpr double most_left = 0.0625;

// dot(normal, x) = distance, x from the middle of the contours.
struct Row {
    Vec3 normal;
    double distance;
};

// An axis, and how far planes are off it: the squares of their distances, and of how much they lean, as far
// out as contours are; in all. Where all are beside it, by how much they differ.
struct Fit {
    Axis axis;
    double square;
};

Fit fit_axis(const std::vector<Row>& rows, double reach, bool beside) {
    const double count = static_cast<double>(rows.size());
    Row mean{{}, 0};
    for (const Row& row : rows) {
        if (!beside) break;
        mean.normal += (1 / count) * row.normal;
        mean.distance += row.distance / count;
    }
    Scatter normals;
    for (const Row& row : rows) normals.add(row.normal - mean.normal);
    Fit fit{{{}, least_direction(normals), 0}, 0};
    const Vec3 direction = fit.axis.direction;
    const Plane across = make_plane({}, direction);
    double uu = 0, uv = 0, vv = 0, ud = 0, vd = 0;
    for (const Row& row : rows) {
        const Vec3 n = row.normal - mean.normal;
        const double u = dot(n, across.u), v = dot(n, across.v), d = row.distance - mean.distance;
        uu += u * u, uv += u * v, vv += v * v;
        ud += u * d, vd += v * d;
    }
    const double determinant = uu * vv - uv * uv;
    if (determinant > 0)
        fit.axis.origin =
            across.to_space({(vv * ud - uv * vd) / determinant, (uu * vd - uv * ud) / determinant});
    fit.square = reach * reach * dot(direction, normals.times(direction));
    for (const Row& row : rows) {
        const double left = dot(row.normal - mean.normal, fit.axis.origin) - (row.distance - mean.distance);
        fit.square += left * left;
    }
    return fit;
}

// In order about a direction, all towards the next one. Returns whether no two neighbours are apart by more
// than those beside an axis may be.
bool put_in_order(std::vector<Row>& rows, Vec3 direction) {
    const Plane across = make_plane({}, direction);
    const auto angle = [&](const Row& row) {
        return std::atan2(dot(row.normal, across.v), dot(row.normal, across.u));
    };
    for (Row& row : rows) {
        if (angle(row) < 0) row = {-1.0 * row.normal, -row.distance};
    }
    std::sort(rows.begin(), rows.end(), [&](const Row& a, const Row& b) { return angle(a) < angle(b); });
    double widest = angle(rows.front()) + std::numbers::pi - angle(rows.back());
    for (std::size_t k = 1; k < rows.size(); ++k)
        widest = std::max(widest, angle(rows[k]) - angle(rows[k - 1]));
    return widest <= widest_beside;
}

// Of the planes, at both ends of the contours along the axis.
double farthest_beside(const ContourSet& set, const Axis& axis) {
    double low = 0, high = 0, farthest = 0;
    for (const Vec3& p : set.points) {
        const double along = dot(p - axis.origin, axis.direction);
        low = std::min(low, along);
        high = std::max(high, along);
    }
    for (const Slice& slice : set.slices) {
        for (const double along : {low, high}) {
            const Vec3 end = axis.origin + along * axis.direction;
            farthest = std::max(farthest, std::abs(slice.plane.signed_distance(end)));
        }
    }
    return farthest;
}

}  // namespace

Axis rotation_axis(const ContourSet& set) {
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    const double reach = 0.25 * box.diagonal();
    std::vector<Row> rows;
    for (const Slice& slice : set.slices)
        rows.push_back({slice.plane.normal, -slice.plane.signed_distance(middle)});
    Fit best = fit_axis(rows, reach, false);
    best.axis.origin += middle;
    if (rows.size() < fewest_beside || !put_in_order(rows, best.axis.direction)) return best.axis;

    best.square *= most_left;
    bool is_beside = false;
    for (Row& first : rows) {  // the turn begins at any of them
        Fit fit = fit_axis(rows, reach, true);
        if (fit.square < best.square) {
            fit.axis.origin += middle;
            best = fit;
            is_beside = true;
        }
        first = {-1.0 * first.normal, -first.distance};
    }
    if (is_beside) best.axis.beside = farthest_beside(set, best.axis);
    return best.axis;
}

}  // namespace anatomesh
