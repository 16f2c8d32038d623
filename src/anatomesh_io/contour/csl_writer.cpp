#include "anatomesh_io/contour/csl_writer.h"

#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/geom/polygon.h"
#include "anatomesh_io/contour/drawn_structures.h"
#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

// D of A x + B y + C z + D = 0. Rounded once through the reader's quotient, after which it stays as it is: a
// reader keeps the plane as a point on the axis that the normal leans to most, at -D / C, and finds -C (-D /
// C).
double plane_offset(const Plane& plane) {
    const Vec3 n = plane.normal;
    const double d = 0.0 - dot(n, plane.origin);
    const double ax = std::abs(n.x), ay = std::abs(n.y), az = std::abs(n.z);
    const double most = az >= ax && az >= ay ? n.z : ay >= ax ? n.y : n.x;
    return 0.0 - most * (0.0 - d / most);
}

struct Loop {
    std::vector<Vec2> polygon;
    double area = 0;  // positive: counter-clockwise
};

bool holds(const Loop& outer, const Loop& hole) {
    for (const Vec2 point : hole.polygon) {
        const Side side = side_of_polygon(outer.polygon, point);
        if (side != Side::on_boundary) return side == Side::inside;
    }
    return true;
}

// The outer contour that each hole of the slice lies in.
std::vector<std::optional<std::size_t>> parents(const ContourSet& set, const Slice& slice) {
    const std::span<const Contour> contours = set.contours_of(slice);
    std::vector<Loop> loops(contours.size());
    for (std::size_t i = 0; i < contours.size(); ++i) {
        for (const Vec3& point : set.points_of(contours[i]))
            loops[i].polygon.push_back(slice.plane.to_plane(point));
        loops[i].area = signed_area(loops[i].polygon);
    }
    std::vector<std::optional<std::size_t>> parent(contours.size());
    for (std::size_t hole = 0; hole < contours.size(); ++hole) {
        if (loops[hole].area >= 0) continue;
        for (std::size_t outer = 0; outer < contours.size(); ++outer) {
            if (contours[outer].structure != contours[hole].structure ||
                loops[outer].area <= -loops[hole].area ||
                (parent[hole] && loops[outer].area >= loops[*parent[hole]].area))
                continue;
            if (holds(loops[outer], loops[hole])) parent[hole] = outer;
        }
    }
    return parent;
}

void append_csl_slice(std::string& out, const ContourSet& set, const Slice& slice, std::size_t id) {
    const std::span<const Contour> contours = set.contours_of(slice);
    std::uint64_t vertices = 0;
    for (const Contour& contour : contours) vertices += contour.point_count;
    out += '\n';
    append_integer(out, id);
    out += ' ';
    append_integer(out, vertices);
    out += ' ';
    append_integer(out, contours.size());
    const Vec3 n = slice.plane.normal;
    for (const double coefficient : {n.x, n.y, n.z, plane_offset(slice.plane)}) {
        out += ' ';
        append_number(out, coefficient);
    }
    out += "\n\n";
    for (const Contour& contour : contours) {
        for (const Vec3& point : set.points_of(contour)) {
            append_number(out, point.x);
            out += ' ';
            append_number(out, point.y);
            out += ' ';
            append_number(out, point.z);
            out += '\n';
        }
    }
    out += '\n';
    const auto parent = parents(set, slice);
    std::uint64_t vertex = 0;
    for (std::size_t i = 0; i < contours.size(); ++i) {
        append_integer(out, contours[i].point_count);
        if (parent[i]) {
            out += 'h';
            append_integer(out, *parent[i]);
        }
        out += ' ';
        append_integer(out, set.structures[contours[i].structure].number);
        for (std::uint32_t k = 0; k < contours[i].point_count; ++k) {
            out += ' ';
            append_integer(out, vertex++);
        }
        out += '\n';
    }
}

}  // namespace

std::string format_csl(const ContourSet& set) {
    std::string out = "CSLC\n";
    append_integer(out, set.slices.size());
    out += ' ';
    append_integer(out, drawn_structures(set).size() + 1);  // the outside is one of the labels
    out += '\n';
    for (std::size_t i = 0; i < set.slices.size(); ++i) append_csl_slice(out, set, set.slices[i], i + 1);
    return out;
}

}  // namespace anatomesh
