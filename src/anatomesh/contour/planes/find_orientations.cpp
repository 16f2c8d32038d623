#include "anatomesh/contour/planes/find_orientations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>

#include "anatomesh/contour/planes/plane_fit.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

// Contours at one coordinate are no accident from this share of all contours' area on.
// [1; 0 to 1; D a choice, measurement not recorded]
constexpr double least_axial_area = 0.1;

// A declared normal, with the contours on its planes.
struct DeclaredNormal {
    Vec3 normal;
    double radius = 0;
    std::size_t points = 0;
    std::vector<std::uint32_t> contours;
};

std::vector<DeclaredNormal> normals_by_plane(std::span<const ContourToPlace> contours,
                                             std::span<const Plane> declared) {
    std::vector<DeclaredNormal> normals;
    for (const Plane& plane : declared) normals.push_back({canonical(plane.normal), 0, 0, {}});
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (contours[c].plane < 0) continue;
        DeclaredNormal& one = normals[static_cast<std::size_t>(contours[c].plane)];
        Box3 box;
        for (const Vec3& p : contours[c].points) box.extend(p);
        one.radius = std::max(one.radius, box.diagonal());
        one.points += contours[c].points.size();
        one.contours.push_back(static_cast<std::uint32_t>(c));
    }
    return normals;
}

// Distinct normals that have contours, the one of the most points first.
std::vector<DeclaredNormal> distinct_normals(std::vector<DeclaredNormal> normals) {
    std::sort(normals.begin(), normals.end(), [](const DeclaredNormal& p, const DeclaredNormal& q) {
        return p.normal != q.normal ? lexicographic_less(p.normal, q.normal) : p.points > q.points;
    });
    std::vector<DeclaredNormal> distinct;
    for (DeclaredNormal& one : normals) {
        if (one.contours.empty()) continue;
        if (distinct.empty() || distinct.back().normal != one.normal) {
            distinct.push_back(std::move(one));
            continue;
        }
        DeclaredNormal& same = distinct.back();
        same.radius = std::max(same.radius, one.radius);
        same.points += one.points;
        same.contours.insert(same.contours.end(), one.contours.begin(), one.contours.end());
    }
    std::stable_sort(distinct.begin(), distinct.end(),
                     [](const DeclaredNormal& p, const DeclaredNormal& q) { return p.points > q.points; });
    return distinct;
}

void place_axis_parallel(std::span<const ContourToPlace> contours, std::span<const double> area,
                         double repair_mm, ContourOrientations& found) {
    std::vector<int> axis_of_contour(contours.size(), -1);
    std::array<double, 3> area_along{};
    double all = 0;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (found.of_contour[c] >= 0) continue;
        axis_of_contour[c] = axis_at_one_coordinate(contours[c].points, repair_mm);
        all += area[c];
        if (axis_of_contour[c] >= 0) area_along[axis_of_contour[c]] += area[c];
    }
    for (const int axis : axial_first) {
        if (area_along[axis] <= 0 || area_along[axis] < least_axial_area * all) continue;
        found.all.push_back(fixed_orientation(coordinate_axes[axis]));
        for (std::size_t c = 0; c < contours.size(); ++c) {
            if (axis_of_contour[c] == axis)
                found.of_contour[c] = static_cast<std::int32_t>(found.all.size()) - 1;
        }
    }
}

// Puts contour c into the orientation that it fits, or into a new one of its own. With `clean_only` a contour that
// neither fits one nor lies on a plane of its own is put off: returns false.
bool place(std::size_t c, std::span<const Vec3> points, bool clean_only, const PlaneTolerance& tolerance,
           ContourOrientations& found) {
    double best = std::numeric_limits<double>::infinity();
    std::size_t chosen = found.all.size();
    for (std::size_t o = 0; o < found.all.size(); ++o) {
        const double deviation = fit_along(points, found.all[o].normal).deviation;
        if (deviation < best) best = deviation, chosen = o;
    }
    bool shows_plane = best <= tolerance.off_plane_mm();
    if (!shows_plane && (clean_only || best > tolerance.repair_mm)) {
        const std::optional<OrientationFit> own =
            clean_only ? clean_orientation(points, tolerance) : damaged_orientation(points);
        if (!own) return false;
        if (is_far_better(*own, best, points.size(), tolerance) ||
            (best > tolerance.repair_mm && own->deviation < best)) {
            chosen = found.all.size();
            found.all.push_back(own->orientation);
            shows_plane = clean_only;
        }
    }
    found.of_contour[c] = static_cast<std::int32_t>(chosen);
    if (!found.all[chosen].fixed) found.all[chosen].add(points, shows_plane);
    return true;
}

}  // namespace

ContourOrientations declared_orientations(std::span<const ContourToPlace> contours,
                                          std::span<const Plane> declared, double tolerance_mm) {
    ContourOrientations found{{}, std::vector<std::int32_t>(contours.size(), -1)};
    // The most used normal speaks for its neighbours.
    for (const DeclaredNormal& one : distinct_normals(normals_by_plane(contours, declared))) {
        std::size_t o = 0;
        while (o < found.all.size() &&
               length(cross(found.all[o].normal, one.normal)) * one.radius > tolerance_mm) {
            ++o;
        }
        if (o == found.all.size()) found.all.push_back(fixed_orientation(one.normal));
        for (const std::uint32_t c : one.contours) found.of_contour[c] = static_cast<std::int32_t>(o);
    }
    return found;
}

ContourOrientations find_orientations(std::span<const ContourToPlace> contours, std::span<const double> area,
                                      const PlaneTolerance& tolerance, ContourOrientations known) {
    ContourOrientations found = std::move(known);
    place_axis_parallel(contours, area, tolerance.repair_mm, found);
    std::vector<std::size_t> rest, damaged;
    for (std::size_t c = 0; c < contours.size(); ++c) {
        if (found.of_contour[c] < 0) rest.push_back(c);
    }
    std::stable_sort(rest.begin(), rest.end(), [&](auto p, auto q) { return area[p] > area[q]; });
    for (const std::size_t c : rest) {
        if (!place(c, contours[c].points, true, tolerance, found)) damaged.push_back(c);
    }
    for (const std::size_t c : damaged) place(c, contours[c].points, false, tolerance, found);
    return found;
}

}  // namespace anatomesh
