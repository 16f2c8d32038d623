// DrawnSlices: what improvement knows of the slices, and the contours that may be re-routed.
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

// The vertex lies in no slice. [1; the largest index; D]
inline constexpr std::uint32_t no_slice = 0xFFFFFFFFu;

// Contours that may leave where they are drawn for where the surface is (reroute_on_section.h).
struct RoutableContours {
    std::span<const Contour> contours = {};        // those of a slice and structure one after the other
    std::span<const std::uint32_t> vertices = {};  // by point of the contours: the mesh vertex
    std::span<const Plane> planes = {};            // by slice
    bool exclusive = false;                        // structures, as in contour sets
    double most_mm = 0;                            // they go no further; 0: they stay. >= 0
};

// What is drawn on slices. The spans refer to arrays that outlive this.
struct DrawnSlices {
    const RegionTable* table = nullptr;  // of the mesh's regions
    // By point of the mesh: the slice in whose plane it lies as a part of a contour, or no_slice. Empty:
    // there are no slices.
    std::span<const std::uint32_t> slice_of;
    const ContourOwners* owners = nullptr;  // of the vertices
    std::span<const Plane> planes = {};     // by slice; empty: cross-sections are not looked at
    // By slice, in its plane: beyond its extent a slice says nothing. Empty: planes are parallel, and each
    // says all.
    std::span<const Box2> extents = {};
    // At structure * planes + slice: 1 / mm^2 drawn; 0 where the slice does not say where the structure is.
    std::span<const double> weights = {};
    double on_plane_mm = 0;  // a vertex this near to a plane lies in it. >= 0
    // Above 0: only sections are looked at of which a larger share of what is drawn is wrong, and only at
    // last, before contours are re-routed. Others beside them may get a little worse.
    double least_wrong = 0;
    // Subsegments, known to the owners, with cells on one side of their structure alone: two vertices and the
    // structure.
    std::span<const std::array<std::uint32_t, 3>> subsegments_beside = {};
    // By vertex: not 0 where contours force the shapes of its cells. Or empty.
    std::span<const std::uint8_t> constraint_limited = {};

    RoutableContours routable = {};

    // Whether one of these vertices, of a cell or a facet, is constraint-limited.
    bool are_constraint_limited(std::span<const std::uint32_t> vertices) const {
        return std::any_of(vertices.begin(), vertices.end(), [&](std::uint32_t v) {
            return v < constraint_limited.size() && constraint_limited[v] != 0;
        });
    }
};

}  // namespace anatomesh
