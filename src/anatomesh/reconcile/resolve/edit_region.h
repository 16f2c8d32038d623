// edit_region: a small region of a slice is added to a structure, or removed from it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

// A contour of a slice after an edit.
struct EditedRing {
    std::uint32_t structure = 0;
    std::vector<Vec3> points;
    bool is_new = false;  // has a point, or an edge, that no contour of the structure had there
};

// What is edited, and where.
struct RegionEdit {
    std::uint32_t slice = 0, structure = 0;
    bool inside = false;  // whether the regions are added to the structure, or removed
    // Polygons, which may overlap each other.
    std::span<const std::vector<Vec3>> regions;
    // Places on segments of contours that polygons have as points. Contours get them first.
    std::span<const IntervalEndpoint> places;
};

// Returns the contours of the slice after the edit. Where structures exclude each other, all others lose
// what is added to the structure, and what is removed from it belongs to nobody. Contours that shared a
// cut segment get its cuts. Points that stay keep their bits; new ones are those of the polygons and their
// crossings with contours. What is narrower than 1e-3 mm is left out.
//
// Returns nothing where contours would cross, touch, or nest as no kept set does, where they would get
// segments shorter than that, or where they cross too often. Requires: a kept contour set. Complexity: O(n
// log n), n points of the slice.
std::optional<std::vector<EditedRing>> edit_region(const ContourSet& set, const RegionEdit& edit);

// Returns how far the contours that changed are from the contours before, or these from them, whichever is
// more. The distance is taken at points and at quarters of edges, mm. It is infinite where nothing of a
// structure is left to measure it to. O(changed points times points of the slice).
double farthest_change(const ContourSet& set, std::uint32_t slice, std::span<const EditedRing> rings);

// Returns the set with these contours on the slice. O(points of the set).
ContourSet with_edited(const ContourSet& set, std::uint32_t slice, std::span<const EditedRing> rings);

}  // namespace anatomesh
