// SlicePath: slices that follow a path, one behind the other, unbent into parallel ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/plane_patches.h"

namespace anatomesh {

// Those contours of a slice that lie on one path. Legs of an arch that are drawn on one plane are two of them.
struct PathSlice {
    std::uint32_t slice = 0;
    std::vector<std::uint32_t> contours;  // of the set, rising
};

// As plane_patches(), of these contours alone. O(points).
PlanePatch patch_of(const ContourSet& set, const PathSlice& part);

// Contours of a vessel are drawn on planes normal to its path, which bends by any angle: two slices far from each
// other along the path may cross, or lie beside each other. So a path knows its neighbours alone. Between two of them
// the path turns about their common line, as a part of a torus does; parallel ones are joined straight. A gap is the
// space between two neighbours, or beyond an end, and has chart coordinates (x, y, z): (x, y) in the frame of either
// slice (mirrored_frame.h), z from the height of the one to that of the other. A point lies in no gap, in one, or in
// several: where legs of an arch lie side by side each has its own.
//
// Guarantees: all points of a slice's contours have that slice's height as their z, exactly, and the x and y of its
// frame; two gaps give the same coordinates on the slice between them. Immutable.
// Source: the frames are those of Wang, Juettler, Zheng and Liu, ACM Trans. Graph. 27, 2008.
class SlicePath {
  public:
    // `slices`: two or more with contours, in the order of the path.
    // Requires: the boxes of two neighbours lie on one side of each other's planes.
    SlicePath(const ContourSet& set, std::vector<PathSlice> slices);

    // In the order of the path.
    std::span<const PathSlice> slices() const { return slices_; }
    // By slice of the path; rising, from 0, as long as the path is between their middles.
    double height(std::size_t n) const { return layers_[n].height; }

    // One more than slices: 0 lies before the first slice, n between the slices n - 1 and n, the last one behind.
    std::size_t gap_count() const { return layers_.size() + 1; }
    // The chart coordinates of p in a gap; nothing where it does not lie there. O(1).
    std::optional<Vec3> to_chart(std::size_t gap, Vec3 p) const;
    // A box in space that holds each point of the gap whose coordinates lie within `reach` of the contours' own.
    Box3 box_of(std::size_t gap, double reach) const;

    // The slices of the path in its order, each with its contours on the path alone, with points in chart
    // coordinates. O(points).
    ContourSet to_chart(const ContourSet& set) const;

    // The plane of the slice nearest to a chart height.
    Plane slice_at(double height) const;

  private:
    struct Layer {
        Plane plane;       // its frame, normals along the path
        double low, high;  // of its contours' points, along the normal
        Box2 box;          // of its contours
        double height;     // along the path
    };
    // Between a layer and the next: about a line in the layer's plane, or straight.
    struct Turn {
        double angle = 0;    // radians; 0: straight
        Vec2 away;           // unit, from the line to the contours
        double line_at = 0;  // of the line along `away`, mm
    };

    static Turn turn_between(const Layer& below, const Layer& above);
    static double length_of(const Layer& below, const Layer& above, const Turn& turn);
    std::optional<Vec3> between(std::size_t gap, Vec3 p) const;

    std::vector<PathSlice> slices_;
    std::vector<Layer> layers_;
    std::vector<Turn> turns_;  // one less than layers
};

}  // namespace anatomesh
