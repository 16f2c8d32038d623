// The paraboloid cap that a part of a drawn region ends with, where its sections shrink towards its last
// slice.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "anatomesh/field/slice/distance_map.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Over a point of the part's last section, as deep in it as the share x of its greatest depth, the part goes
// on to the height `top`, but not beyond the paraboloid rise * x (2 - x): over a disc its section then
// shrinks by equal areas, as that of a ball does.
class ParaboloidCap {
  public:
    // Requires: all > 0, mm. `depth`: the greatest of the section.
    ParaboloidCap(double depth, double rise, double top) : depth_(depth), rise_(rise), top_(top) {}

    // Its height over a point at the signed distance d from the section's boundary; 0 outside.
    double height(double d) const {
        const double x = std::clamp(-d / depth_, 0.0, 1.0);
        return std::min(top_, rise_ * x * (2 - x));
    }

    // Negative inside; at the height h >= 0: d at h = 0, zero on the paraboloid cap, and about the distance
    // near it. Continuous.
    double value(double d, double h) const {
        const double rim = 2 * rise_ / depth_;  // its slope there
        const double over = height(d), slope = rim * std::max(0.0, 1 + d / depth_);
        if (!(over > 0)) return std::max(d, (rim * d + h) / std::sqrt(1 + rim * rim));
        const double share = std::min(1.0, h / over);
        const double steepness = std::min(1.0, over / (-d * std::sqrt(1 + slope * slope)));
        return -d * (h / over - 1) * (1 - share + share * steepness);
    }

    bool is_whole() const { return top_ >= rise_; }  // its top is not cut off

  private:
    double depth_, rise_, top_;
};

// The paraboloid cap of a part that is drawn as `section` and ends within `gap` (> 0, mm) of it, from how its
// boundary lies in the region on the slice before, `gap_before` (> 0) away: the area goes on to fall as fast
// as it fell between the two. Where that is nothing before the next slice, it is where the paraboloid cap
// ends; else the paraboloid cap is cut off so low that it has the volume of half the gap. `is_void`: the part
// is a hole of that region. Nothing where the section hardly shrinks: it ends flat. Requires: the section's
// distances reach as far as it is deep.
std::optional<ParaboloidCap> paraboloid_cap_of(const DistanceMap& section, bool is_void,
                                               const DistanceMap& before, double gap_before, double gap);

}  // namespace anatomesh
