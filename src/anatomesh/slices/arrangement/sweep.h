// Sweep: slices side by side that lean against each other, unwarped into parallel ones.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// A probe that is swept over the body, or a patient who moved a little, gives slices that follow one another
// without being parallel. Each is taken as the mirror image of the one before in the plane half-way between
// them; so every slice gets a frame of its own, and a point between two slices the mean of its projections
// onto both, weighted with its distances from them: chart coordinates (x, y, z), in which the slices are
// parallel to z = 0. For parallel slices this is a rigid movement.
//
// Guarantees: all points of a slice's contours have that slice's height as their z, exactly, and the x and y
// of its frame; continuous; z rises from slice to slice wherever the slices do not cross. Immutable.
class Sweep {
  public:
    // Nothing unless the slices can be put in an order such that the boxes of all contours before a slice lie
    // below its plane and those of all after it above; neighbours lean by 10 degrees at most against each
    // other and all of them by 60 against their mean; and the distance of two neighbours, over the boxes of
    // their contours, is nowhere less than a fifth of its mean. (Of a slice without contours: at the point of
    // it nearest to the middle of the set.) Requires: a contour. Complexity: O(points + slices^2).
    static std::optional<Sweep> of(const ContourSet& set);

    // The slices in the order of the sweep, from below.
    std::vector<std::uint32_t> order() const;

    // Complexity: logarithmic in the slices.
    Vec3 to_chart(Vec3 p) const;

    // The plane of the slice nearest to a chart height.
    Plane slice_at(double height) const;

    // The set with its points in chart coordinates; its slices keep their order.
    ContourSet to_chart(const ContourSet& set) const;

    // A box that holds every point whose chart coordinates lie within `reach` of the contours' own.
    // Requires: `box` holds the contours.
    Box3 around(const Box3& box, double reach) const { return box.grown(most_stretched * reach); }

  private:
    struct Layer {
        Plane plane;          // its frame, normals all the same way
        double low, high;     // of its contours' points, along the normal
        double height;        // straight
        std::uint32_t slice;  // of the set
    };
    // Where planes spread, a millimetre of the chart is so many in space at most: gaps of a fifth to twice
    // their mean are nearly all. [mm per mm; >= 1; D]
    static constexpr double most_stretched = 2;

    std::vector<Layer> layers_;  // in the order of the sweep
};

}  // namespace anatomesh
