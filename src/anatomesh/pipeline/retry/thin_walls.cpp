#include "anatomesh/pipeline/retry/thin_walls.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "anatomesh/geom/point_triangle.h"

namespace anatomesh {

namespace {

// Another structure's contour so near makes a wall. [sizes; 0 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr double near_share = 0.2;
// Nearer than this, a vertex is on the other contour. [sizes; 0 to near_share; M 2026-11, set not recorded]
constexpr double shared_share = 2e-3;
// A structure has walls all round if such a share of its vertices runs beside others. [share; 0 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr double least_part = 0.5;
// So many thicknesses make an edge with which cells between two surfaces are no flakes. [thicknesses; > 0; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr double sizes_across = 2.5;
// An edge length that is hardly shorter is not worth another model. [ratio; 0 to 1; M 2026-11, set not recorded]
constexpr double finer_by = 0.7;
// So many cells are made for each square of an edge on the surfaces; 40 to 75 were seen. [cells; > 0; M 2026-11, docs/experiments/2026-11-28-retries.md]
constexpr double cells_per_square = 75;
// So many vertices of a contour are looked at. [vertices; > 0; B]
constexpr std::size_t most_looked_at = 64;

// From the contours of other structures in the slice that come within `reach`; infinite without any.
double distance_from_others(const ContourSet& set, const Contour& contour, std::span<const Box3> boxes,
                            Vec3 p, double reach) {
    const Slice& slice = set.slices[contour.slice];
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t c = 0; c < slice.contour_count; ++c) {
        const Contour& other = set.contours[slice.first_contour + c];
        if (other.structure == contour.structure || !boxes[slice.first_contour + c].grown(reach).contains(p))
            continue;
        const std::span<const Vec3> points = set.points_of(other);
        for (std::size_t n = 0; n < points.size(); ++n)
            nearest =
                std::min(nearest, point_segment_distance(p, points[n], points[(n + 1) % points.size()]));
    }
    return nearest;
}

struct Beside {
    std::vector<double> distances;  // of vertices near others
    std::size_t looked_at = 0;
    double drawn = 0;  // length of all contours

    bool is_wall() const {
        return !distances.empty() &&
               static_cast<double>(distances.size()) >= least_part * static_cast<double>(looked_at);
    }
};

std::vector<Beside> look_beside(const ContourSet& contours, double size) {
    std::vector<Box3> boxes(contours.contours.size());
    for (std::size_t c = 0; c < boxes.size(); ++c) {
        for (const Vec3& p : contours.points_of(contours.contours[c])) boxes[c].extend(p);
    }
    std::vector<Beside> beside(contours.structures.size());
    for (const Contour& contour : contours.contours) {
        const std::span<const Vec3> points = contours.points_of(contour);
        Beside& own = beside[contour.structure];
        for (std::size_t n = 0; n < points.size(); ++n)
            own.drawn += length(points[(n + 1) % points.size()] - points[n]);
        const std::size_t step = (points.size() + most_looked_at - 1) / most_looked_at;
        for (std::size_t n = 0; n < points.size(); n += step) {
            const double distance =
                distance_from_others(contours, contour, boxes, points[n], near_share * size);
            ++own.looked_at;
            if (distance <= near_share * size && distance > shared_share * size)
                own.distances.push_back(distance);
        }
    }
    return beside;
}

}  // namespace

std::optional<WallSize> wall_size(const ContourSet& contours, double size_mm, double spacing_mm) {
    assert(size_mm > 0 && spacing_mm > 0);
    double thickness = std::numeric_limits<double>::infinity(), all = 0, of_walls = 0;
    for (Beside& own : look_beside(contours, size_mm)) {
        all += own.drawn;
        if (!own.is_wall()) continue;
        of_walls += own.drawn;
        const auto middle = own.distances.begin() + static_cast<std::ptrdiff_t>(own.distances.size() / 2);
        std::nth_element(own.distances.begin(), middle, own.distances.end());
        thickness = std::min(thickness, *middle);
    }
    const double size = sizes_across * thickness;
    if (!(size < finer_by * size_mm)) return std::nullopt;
    return WallSize{size, thickness, cells_per_square * all * spacing_mm / (size * size), of_walls / all};
}

}  // namespace anatomesh
