#include "anatomesh/field/rotation_axis.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "anatomesh/contour/point_scatter.h"

namespace anatomesh {

namespace {

constexpr std::size_t fewest_beside = 8;  // planes beside an axis: an axis and a distance fit fewer by chance
constexpr double most_left = 0.0625;      // of the squared distances

// Of the planes across the direction: dot(normal, x) = distance.
struct Row {
    Vec2 normal;
    double distance;
};

struct Nearest {
    Vec2 at;
    double square;  // of the distances that are left, in all
};

// Of all planes, or, `beside`, of all that are moved against their normals by one distance.
Nearest nearest_to(const std::vector<Row>& rows, bool beside) {
    const double count = static_cast<double>(rows.size());
    Row mean{{0, 0}, 0};
    for (const Row& row : rows) {
        if (!beside) break;
        mean.normal = mean.normal + (1 / count) * row.normal;
        mean.distance += row.distance / count;
    }
    double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;
    for (const Row& row : rows) {
        const Vec2 n = row.normal - mean.normal;
        const double d = row.distance - mean.distance;
        xx += n.x * n.x, xy += n.x * n.y, yy += n.y * n.y;
        xd += n.x * d, yd += n.y * d;
    }
    const double determinant = xx * yy - xy * xy;
    Nearest nearest{{0, 0}, 0};
    if (determinant > 0) nearest.at = {(yy * xd - xy * yd) / determinant, (xx * yd - xy * xd) / determinant};
    for (const Row& row : rows) {
        const double left = dot(row.normal - mean.normal, nearest.at) - (row.distance - mean.distance);
        nearest.square += left * left;
    }
    return nearest;
}

}  // namespace

Axis rotation_axis(const ContourSet& set) {
    Scatter normals;
    for (const Slice& slice : set.slices) normals.add(slice.plane.normal);
    const Vec3 direction = least_direction(normals);
    const Box3 box = set.box();
    const Plane across = make_plane(0.5 * (box.low + box.high), direction);
    std::vector<Row> rows;
    for (const Slice& slice : set.slices) {
        const Plane& plane = slice.plane;
        rows.push_back({{dot(plane.normal, across.u), dot(plane.normal, across.v)},
                        -plane.signed_distance(across.origin)});
    }
    const Nearest through = nearest_to(rows, false);
    if (rows.size() < fewest_beside) return {across.to_space(through.at), direction};

    // In order about the axis, all towards the next one; the turn begins at any of them.
    const auto turned_over = [](Row& row) { row = {-1.0 * row.normal, -row.distance}; };
    for (Row& row : rows) {
        if (row.normal.y < 0 || (row.normal.y == 0 && row.normal.x < 0)) turned_over(row);
    }
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
        return std::atan2(a.normal.y, a.normal.x) < std::atan2(b.normal.y, b.normal.x);
    });
    Nearest beside = through;
    for (Row& first : rows) {
        const Nearest from_here = nearest_to(rows, true);
        if (from_here.square < beside.square) beside = from_here;
        turned_over(first);
    }
    const bool is_beside = beside.square < most_left * through.square;
    return {across.to_space(is_beside ? beside.at : through.at), direction};
}

}  // namespace anatomesh
