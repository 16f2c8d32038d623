#include "anatomesh/pipeline/estimate.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

// So many tetrahedra come for each square of the edge length on the surface: 13 for thin bone, 73 for brains.
// [tetrahedra; > 0; M 2026-11 heads, spines, organs and bones at 1.4 to 4.3 mm]
constexpr double tetrahedra_per_area = 30;
// So many tetrahedra come for each cube of the edge length: a solid filled with lattice points has six for
// each point, two points a cube. [tetrahedra; > 0; D]
constexpr double tetrahedra_per_volume = 12;
// A whole run takes so much memory for each tetrahedron that it ends with.
// [bytes; > 0; M 2026-11, set not recorded]
constexpr double bytes_per_tetrahedron = 700;
// The default edge length is at most so many slice spacings, as the estimate of its cells has to know.
// [slice spacings; > 0; C]
constexpr double default_spacings = 2;
// Vertices so many spacings apart are far coarser than the slices: then the default edge length is finer than
// the drawing. [slice spacings; > default_spacings; B]
constexpr double far_coarser = 4;
// A default edge length that makes more tetrahedra is refused: it takes minutes and some 7 GB that nobody
// asked for. [tetrahedra; > 0; B]
constexpr double nobody_asked_for = 1e7;

double length_of(std::span<const Vec3> ring) {
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) sum += length(ring[i] - ring[(i + 1) % ring.size()]);
    return sum;
}

double area_of(std::span<const Vec3> ring, const Plane& plane) {
    Vec3 twice;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        twice = twice + cross(ring[i] - ring[0], ring[(i + 1) % ring.size()] - ring[0]);
    }
    return 0.5 * dot(twice, plane.normal);
}

}  // namespace

double estimated_tetrahedra(const ContourSet& contours, double size_mm) {
    const double spacing = all_parallel(contours, parallel_tolerance_mm) ? median_spacing(contours) : 0;
    if (!(spacing > 0)) return 0;
    double wall = 0, volume = 0, before = 0;
    for (const Slice& slice : contours.slices) {
        double drawn = 0;
        for (const Contour& contour : contours.contours_of(slice)) {
            wall += spacing * length_of(contours.points_of(contour));
            drawn += area_of(contours.points_of(contour), slice.plane);
        }
        drawn = std::abs(drawn);
        wall += std::abs(drawn - before);  // the ends, and where it steps from slice to slice
        volume += spacing * drawn;
        before = drawn;
    }
    wall += before;
    const double by_area = tetrahedra_per_area * wall / (size_mm * size_mm);
    const double by_volume = tetrahedra_per_volume * volume / (size_mm * size_mm * size_mm);
    return size_mm < spacing ? std::min(by_area, by_volume) : by_area;
}

Status check_size(const ContourSet& contours, double size_mm, const SizeLimits& limits) {
    const double cells = estimated_tetrahedra(contours, size_mm);
    const double bytes = cells * bytes_per_tetrahedron;
    const auto allowed = static_cast<double>(limits.memory_bytes);
    std::string more_than, limit;
    if (cells > static_cast<double>(limits.tetrahedra)) {
        more_than = std::to_string(limits.tetrahedra);
        limit = "tetrahedra";
    } else if (allowed > 0 && bytes > allowed) {
        more_than = significant_text(allowed / 1e9, 3) + " GB of memory hold";
        limit = "memory-bytes";
    } else {
        return Nothing{};
    }
    return Error{ErrorKind::limit,
                 "E-CMD-014",
                 "an edge length of " + plain_text(size_mm) + " mm would make about " +
                     significant_text(cells, 2) + " tetrahedra, more than " + more_than,
                 {contours.source, "", "", "", "--size " + plain_text(size_mm)},
                 "give a larger --size, or raise the limit with --limit " + limit + "=N"};
}

Status check_default_size(const ContourSet& contours) {
    const double spacing = median_spacing(contours);
    double total = 0;
    for (const Contour& contour : contours.contours) total += length_of(contours.points_of(contour));
    const double between_vertices =
        total / static_cast<double>(std::max<std::size_t>(1, contours.points.size()));
    if (!(spacing > 0) || between_vertices < far_coarser * spacing) return Nothing{};
    const double size = default_spacings * spacing, cells = estimated_tetrahedra(contours, size);
    if (!(cells > nobody_asked_for)) return Nothing{};
    const double enough = size * std::sqrt(cells / nobody_asked_for);
    return Error{
        ErrorKind::limit,
        "E-CMD-014",
        "the slices are " + significant_text(spacing, 3) + " mm apart and need an edge length of " +
            significant_text(size, 3) + " mm, which makes about " + significant_text(cells, 2) +
            " tetrahedra",
        {contours.source, "", "", "", significant_text(between_vertices, 3) + " mm between vertices"},
        "check the distance of the slices, or give a longer edge, such as --size " +
            significant_text(enough, 2)};
}

}  // namespace anatomesh
