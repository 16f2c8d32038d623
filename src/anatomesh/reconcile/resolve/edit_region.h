// edit_region: a small region of a slice is given to a structure, or taken from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// A contour of a slice after that.
struct EditedRing {
    std::uint32_t structure = 0;
    std::vector<Vec3> points;
    bool is_new = false;  // has a point, or an edge, that no contour of the structure had there
};

// What is painted where.
struct RegionEdit {
    std::uint32_t slice = 0, structure = 0;
    bool inside = false;  // whether the regions come to be the structure's, or cease to
    // Polygons, which may overlap each other.
    std::span<const std::vector<Vec3>> regions;
    // Places on segments of contours that polygons have as points: put into the contours first.
    std::span<const IntervalEndpoint> places;
};

// The contours of the slice with the regions painted: of the one structure, and of all others too where
// structures exclude each other: they lose what becomes its, and what ceases to be its is nobody's. Contours
// that shared a cut segment get its cuts. Points that stay keep their bits; new ones are the polygons' and
// the crossings with them; what is narrower than 1e-3 mm is left out. Nothing where contours would cross,
// touch, or nest as no kept set does, where they would get segments as short as that, or where they cross too
// often. Requires: a kept contour set. Complexity: O(n log n), n points of the slice.
std::optional<std::vector<EditedRing>> edit_region(const ContourSet& set, const RegionEdit& edit);

// How far the contours that changed come from where they were, or were from where they come: the largest
// distance, over points and points a quarter of the way along edges, mm; infinite where nothing of a
// structure is left to measure it to. O(changed points times points of the slice).
double farthest_change(const ContourSet& set, std::uint32_t slice, std::span<const EditedRing> rings);

// The set with these contours on the slice. O(points of the set).
ContourSet with_edited(const ContourSet& set, std::uint32_t slice, std::span<const EditedRing> rings);

}  // namespace anatomesh
