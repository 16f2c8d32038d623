// route_contours: a contour set of which some contours were re-routed along the surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/mesh/model/routed_contour.h"

namespace anatomesh {

struct ContoursOfMesh {
    ContourSet contours;
    std::vector<std::uint32_t> vertices;  // of the mesh, of every point of the contours
};

// `vertex_of`: of every point of the set. `routed`: in the order of the contours. `points`: of the mesh.
// Points of contours that were not led keep their coordinates. Requires: a kept contour set. Guarantees:
// contours and points in the order of kept contour sets. Complexity: O(n log n).
ContoursOfMesh route_contours(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                              std::span<const RoutedContour> routed, std::span<const Vec3> points);

// Leaves those as they are drawn that make the contours of their slices touch, cross or turn over: they did
// not where they were re-routed, but coordinates were rounded since. Complexity: O(n log n).
void drop_unsound(const ContourSet& set, std::vector<RoutedContour>& routed, std::span<const Vec3> points);

// By vertex of the mesh: whether a contour of the set runs through it, as it is now. As above. O(n).
std::vector<std::uint8_t> kept_vertices(const ContourSet& set, std::span<const std::uint32_t> vertex_of,
                                        std::span<const RoutedContour> routed, std::size_t vertex_count);

// What the report says of them. `set`: as drawn. Distances are those of what is drawn and what is re-routed
// between two vertices that a contour has both times. Complexity: that of even_odd_area(), and the square of
// the points between two such vertices.
std::vector<RoutedContourReport> routed_contour_reports(const ContourSet& set,
                                                        std::span<const std::uint32_t> vertex_of,
                                                        std::span<const RoutedContour> routed,
                                                        std::span<const Vec3> points);

}  // namespace anatomesh
