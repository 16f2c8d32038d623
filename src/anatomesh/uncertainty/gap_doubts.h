// GapDoubts: how much of the structures is in doubt where slices are missing and the field joins no two
// sides.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/plane.h"
#include "anatomesh/slices/arrangement/sweep.h"

namespace anatomesh {

// A plane, and the slices that it lies between; only a: beyond it.
struct PlaneBetween {
    Plane plane;
    std::int64_t slice_a = -1, slice_b = -1;
};

// In a stack or a sweep a structure ends on both sides of a gap of more than max_gap_spacings (W-FLD-001).
// Contours do not say whether it goes on in between. Of the volume between the two ends, mean of the areas
// drawn on both sides x height, the share 1/2 (1 - widest gap that is joined / this gap) is to be expected as
// error: none where the field would just join it, half of a wide one. The share grows with the gap, so that a
// contour half-way takes away most. Planes in other positions have no such gaps.
class GapDoubts {
  public:
    // Requires: a kept contour set with a contour. Complexity: O(points).
    GapDoubts(const ContourSet& set, const FieldOptions& options);

    // The planes half-way through the gaps.
    std::vector<PlaneBetween> middles() const;

    // Whether two slices have a whole gap, and slices beside it, between them: its own middle stands for
    // theirs.
    bool is_across(const PlaneBetween& between) const;

    // The expected error, mm^3, of all structures.
    double volume() const;

    // What contours on a plane through p take away of it; also added to `by_structure`.
    double gain(Vec3 p, std::vector<double>& by_structure) const;

    // Takes contours on a plane through p as drawn.
    void draw(Vec3 p);

  private:
    struct Gap {
        std::uint32_t structure = 0, slice_a = 0, slice_b = 0;
        double first = 0, last = 0;    // heights of these slices
        double low = 0, high = 0;      // of the nearest contours, drawn or taken as drawn
        double spacing = 0, area = 0;  // of the structure there
    };
    double doubt(const Gap& gap) const;
    double height_of(Vec3 p) const;

    double max_gap_spacings_;
    Plane frame_;
    std::optional<Sweep> sweep_;
    std::vector<Gap> gaps_;
    std::vector<Plane> planes_;  // of the slices, about the middle of their contours
};

}  // namespace anatomesh
