// OtherSlices, DrawnPolygons: what a change of a slice's contours is held against, the other slices and what is drawn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

// The boxes of what each slice draws. Complexity: O(points).
std::vector<Box3> boxes_of_slices(const ContourSet& set);

// The planes of a set beside that of one slice. The set and the boxes are referred to and must outlive this.
class OtherSlices {
  public:
    // `boxes`: boxes_of_slices() of the set.
    OtherSlices(const ContourSet& set, std::uint32_t slice, const std::vector<Box3>& boxes)
        : set_(set), slice_(slice), boxes_(boxes) {}

    using Ends = std::array<std::optional<Vec2>, 2>;
    // Returns whether another slice passes through a polygon of this one's plane: the two agree as drawn, or are made
    // to. One that passes through no more of it than common vertices at its ends, which stay as they are, does not.
    // Complexity: O(slices x polygon).
    bool cross(const std::vector<Vec2>& ring, const Ends& ends) const;

  private:
    const ContourSet& set_;
    std::uint32_t slice_;
    const std::vector<Box3>& boxes_;
};

// The loops of a slice as they are drawn.
class DrawnPolygons {
  public:
    void add(std::vector<Vec2> polygon);
    // Signed, counterclockwise positive. O(polygon).
    double area(std::size_t loop) const;
    // Returns whether a point lies in the loops from the first on, up to the last, by the even-odd rule. O(points).
    bool is_inside(std::size_t first, std::size_t last, Vec2 p) const;

  private:
    std::vector<std::vector<Vec2>> polygons_;
    std::vector<Box2> boxes_;
};

}  // namespace anatomesh
