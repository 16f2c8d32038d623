#include "anatomesh/reconcile/move/snap_planes_to_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

namespace {

// Fewer planes are no scan about an axis. [planes; >= 3; M 2026-11 ellipsoid of 36 planes rounded to 0.01 mm]
constexpr std::size_t least_planes = 5;
// So many slices are paired with all others to find the axis: one of three is on it where most are. [slices;
// >= 1; B]
constexpr std::uint32_t most_firsts = 3;
// Fewer planes than most of all pass a line as near as this by no accident: two of them always do. [mm; > 0;
// M 2026-11 fans of 3 to 9 planes with a stack, rounded to 0.0001 and 0.001 mm]
constexpr double closely_rounded_mm = 0.002;
// So many planes at least. [planes; >= 3; D]
constexpr std::size_t least_planes_of_some = 3;
// So many such axes are looked for. [axes; >= 1; B]
constexpr int most_axes = 16;
// To find one, planes are tried with lines of two others so often. [tries; > 0; B]
constexpr std::size_t most_tries_of_planes = 50'000'000;
// Two planes at a smaller angle do not fix where the axis is.
// [1, sine; 0 to 1; M 2026-11 ellipsoid of 36 planes rounded to 0.01 mm]
constexpr double least_axis_sine = 0.01;

// A straight line between two points, which are as far apart as contours reach along it.
struct AxisSegment {
    std::array<Vec3, 2> ends;
    Vec3 direction() const { return normalized(ends[1] - ends[0]); }
};

// Which planes an axis is sought of, and how.
struct AxisSearch {
    std::uint32_t firsts = 0;        // slices that are paired with all others
    std::size_t least_planes = 0;    // through the axis
    double within_mm = 0;            // of it
    std::vector<bool> leaves_out{};  // by slice; empty: none
};

bool is_left_out(const AxisSearch& search, std::uint32_t slice) {
    return !search.leaves_out.empty() && search.leaves_out[slice];
}

bool runs_through(const Plane& plane, const AxisSegment& axis, double within_mm) {
    return std::all_of(axis.ends.begin(), axis.ends.end(),
                       [&](Vec3 p) { return std::abs(plane.signed_distance(p)) <= within_mm; });
}

// Returns the common line of two planes, as far as the box of all contours reaches along it.
std::optional<AxisSegment> common_line(const Box3& box, const Plane& p, const Plane& q) {
    const Vec3 way = cross(p.normal, q.normal);
    const double sine = length(way);
    if (sine < least_axis_sine) return std::nullopt;
    // This is the point of both planes that is nearest to p's origin.
    const Vec3 across = cross(way, p.normal);
    const Vec3 at = p.origin - (q.signed_distance(p.origin) / dot(across, q.normal)) * across;
    const Vec3 direction = (1 / sine) * way;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 x{(corner & 1 ? box.high : box.low).x, (corner & 2 ? box.high : box.low).y,
                     (corner & 4 ? box.high : box.low).z};
        low = std::min(low, dot(x - at, direction));
        high = std::max(high, dot(x - at, direction));
    }
    if (!(low < high)) return std::nullopt;
    return AxisSegment{{at + low * direction, at + high * direction}};
}

std::vector<std::uint32_t> planes_through(const ContourSet& set, const AxisSegment& axis,
                                          const AxisSearch& search) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (!is_left_out(search, s) && runs_through(set.slices[s].plane, axis, search.within_mm))
            found.push_back(s);
    }
    return found;
}

// Returns the line that most planes pass, of the lines of some slices with all others.
std::optional<AxisSegment> axis_of_most(const ContourSet& set, const AxisSearch& search) {
    Box3 box;
    for (const Vec3& p : set.points) box.extend(p);
    std::optional<AxisSegment> best;
    std::size_t most = search.least_planes - 1;
    for (std::uint32_t a = 0; a < search.firsts; ++a) {
        for (std::uint32_t b = a + 1; b < set.slices.size(); ++b) {
            if (is_left_out(search, a) || is_left_out(search, b)) continue;
            const std::optional<AxisSegment> axis =
                common_line(box, set.slices[a].plane, set.slices[b].plane);
            if (!axis) continue;
            const std::size_t count = planes_through(set, *axis, search).size();
            if (count <= most) continue;
            most = count;
            best = axis;
        }
    }
    return best;
}

// Returns an end of the axis, moved across it to where the sum of squared distances from the planes is
// least.
Vec3 nearest_to_all(const ContourSet& set, const std::vector<std::uint32_t>& slices, Vec3 end,
                    Vec3 direction) {
    const Plane across = make_plane(end, direction);
    double uu = 0, uv = 0, vv = 0, ud = 0, vd = 0;
    for (const std::uint32_t s : slices) {
        const Plane& plane = set.slices[s].plane;
        const double u = dot(plane.normal, across.u), v = dot(plane.normal, across.v),
                     d = plane.signed_distance(end);
        uu += u * u;
        uv += u * v;
        vv += v * v;
        ud += u * d;
        vd += v * d;
    }
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) return end;
    return across.to_space({(uv * vd - vv * ud) / determinant, (uv * ud - uu * vd) / determinant});
}

// Returns the plane, turned to contain the axis.
Plane through(const Plane& plane, const AxisSegment& axis) {
    const Vec3 direction = axis.direction();
    const Vec3 normal = normalized(plane.normal - dot(plane.normal, direction) * direction);
    return make_plane(plane.origin + dot(axis.ends[0] - plane.origin, normal) * normal, normal);
}

bool keeps_points(const ContourSet& set, const Slice& slice, const Plane& plane, double within) {
    for (const Contour& contour : set.contours_of(slice)) {
        for (const Vec3& p : set.points_of(contour))
            if (std::abs(plane.signed_distance(p)) > within) return false;
    }
    return true;
}

// Turns planes to contain the axis that they all but pass. Returns the number of those turned.
std::uint32_t turn_about(ContourSet& set, const AxisSegment& rough, const std::vector<std::uint32_t>& slices,
                         double within) {
    const AxisSegment axis{{nearest_to_all(set, slices, rough.ends[0], rough.direction()),
                            nearest_to_all(set, slices, rough.ends[1], rough.direction())}};
    std::uint32_t turned = 0;
    for (const std::uint32_t s : slices) {
        Plane& plane = set.slices[s].plane;
        const double off = std::max(std::abs(plane.signed_distance(axis.ends[0])),
                                    std::abs(plane.signed_distance(axis.ends[1])));
        if (off <= line_in_plane_mm) continue;
        const Plane truly = through(plane, axis);
        if (!keeps_points(set, set.slices[s], truly, within)) continue;
        plane = truly;
        ++turned;
    }
    return turned;
}

// Turns most planes about the one axis that they pass, then some about each axis that they pass more nearly.
// A plane is turned about one axis only.
std::uint32_t turn_about_axes(ContourSet& set, double mm) {
    const std::size_t count = set.slices.size();
    std::vector<bool> done(count, false);
    std::uint32_t turned = 0;
    const auto turn = [&](const AxisSearch& search) {
        const std::optional<AxisSegment> rough = axis_of_most(set, search);
        if (!rough) return false;
        const std::vector<std::uint32_t> slices = planes_through(set, *rough, search);
        turned += turn_about(set, *rough, slices, rounded_plane_mm * mm);
        for (const std::uint32_t s : slices) done[s] = true;
        return true;
    };
    if (count >= least_planes) {
        const auto firsts = std::min<std::uint32_t>(most_firsts, static_cast<std::uint32_t>(count));
        turn({firsts, std::max(least_planes, count / 2 + 1), rounded_plane_mm * mm, {}});
    }
    const auto firsts =
        static_cast<std::uint32_t>(std::min(count, most_tries_of_planes / (count * count + 1)));
    for (int n = 0; n < most_axes; ++n) {
        if (!turn({firsts, least_planes_of_some, closely_rounded_mm * mm, done})) break;
    }
    return turned;
}

}  // namespace

PlaneSnappingStats snap_planes_to_axis(ContourSet& set, double mm) {
    PlaneSnappingStats stats;
    stats.about_axis = turn_about_axes(set, mm);
    for (const Contour& contour : set.contours) {
        const Plane& plane = set.slices[contour.slice].plane;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const double off = plane.signed_distance(set.points[k]);
            if (std::abs(off) <= line_in_plane_mm) continue;
            set.points[k] = set.points[k] - off * plane.normal;
            ++stats.points;
            stats.farthest_mm = std::max(stats.farthest_mm, std::abs(off));
        }
    }
    return stats;
}

}  // namespace anatomesh
