// What improvement is told of the slices: what is drawn in their planes, and the contours that may be re-routed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/box.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

using VertexPair = std::array<std::uint32_t, 2>;  // smaller vertex first

inline constexpr std::uint32_t no_slice = 0xFFFFFFFFu;

// All contours, which may leave where they are drawn for where the surface is (reroute_on_section.h).
struct RoutableContours {
    std::span<const Contour> contours = {};        // those of a slice and structure one after the other
    std::span<const std::uint32_t> vertices = {};  // of the mesh, of every point of theirs
    std::span<const Plane> planes = {};            // by slice
    bool exclusive = false;                        // structures, as in contour sets
    double most_mm = 0;                            // no further; 0: they stay. >= 0
};

// One that did.
struct RoutedContour {
    std::uint32_t contour = 0;            // its index
    std::vector<std::uint32_t> vertices;  // all, in order
    std::uint64_t segments = 0;           // drawn, missed before and not any more
    double farthest_mm = 0;               // of it from what was drawn, and of that from it
    friend bool operator==(const RoutedContour&, const RoutedContour&) = default;
};

// What is drawn on slices, for the facets in their planes.
struct DrawnSlices {
    const RegionTable* table = nullptr;       // of the mesh's regions
    std::span<const std::uint32_t> slice_of;  // for every point of the mesh the slice in whose plane it lies
                                              // as a part of a contour, or no_slice; empty: no slices
    const ContourOwners* owners = nullptr;    // of the vertices
    std::span<const Plane> planes = {};       // by slice, or empty: cuts are not looked at
    std::span<const Box2> extents = {};       // by slice, in its plane: beyond them it says nothing; empty:
                                              // planes are parallel, and each says all
    std::span<const double> weights = {};     // at structure * planes + slice: 1 / mm^2 drawn; 0 where the
                                              // slice does not tell where the structure is
    double on_plane_mm = 0;                   // a vertex this near to a plane lies in it. >= 0
    // Above 0: of cuts those alone are looked at, and at last, before contours are re-routed, of which so
    // large a share of what is drawn is wrong then. Others beside them may get a little worse.
    double least_wrong = 0;
    // Subsegments, known to the owners, with cells on one side of their structure alone: two
    // vertices and the structure.
    std::span<const std::array<std::uint32_t, 3>> subsegments_beside = {};
    std::span<const std::uint8_t> constraint_limited =
        {};  // by vertex: contours force the shapes of its cells; or empty

    RoutableContours routable = {};

    // Whether one of these vertices, of a cell or a facet, is.
    bool are_constraint_limited(std::span<const std::uint32_t> vertices) const {
        return std::any_of(vertices.begin(), vertices.end(), [&](std::uint32_t v) {
            return v < constraint_limited.size() && constraint_limited[v] != 0;
        });
    }
};

}  // namespace anatomesh
