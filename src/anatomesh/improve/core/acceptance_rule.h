// AcceptanceRule: what a change of the mesh must achieve to be accepted.
#pragma once

#include <algorithm>
#include <cmath>

#include "anatomesh/base/contract.h"

namespace anatomesh {

// What the cells of a cavity are before a change; the cells in their place are compared with it.
struct QualityThreshold {
    double sine = 1;           // the worst inside
    double outside_sine = 1;   // the worst outside
    double squared_ratio = 0;  // the largest inside
};

// The figure that a change must better.
enum class Objective { least_sine, radius_edge };

// The rule by which the operations judge the cells that they would make. A profile of the hill climber
// (climb_profile.h) sets it for a pass. Sines are those of dihedral angles, ratios those of circumradius over
// shortest edge. Complexity: O(1) each.
struct AcceptanceRule {
    Objective objective = Objective::least_sine;
    // New cells inside have no larger ratio, but in the place of one as large; where the objective is the
    // ratio, the place of a larger one is no excuse unless the ratio gets lower. >= 1.2
    double max_radius_edge = contract::max_radius_edge;
    // New cells inside have no smaller sine; where the objective is the ratio, they may in the place of one
    // as small. 0 to 1
    double least_sine = 0;
    // Where the objective is the ratio, these bounds hold whatever the replaced cells are.
    double strict_least_sine = 0;
    double strict_max_ratio = HUGE_VAL;
    bool moves_junctions = false;  // vertices where three or more regions meet may move
    bool guards_sections =
        false;  // no facet comes to lie in a slice's plane where the slice has other regions
    bool spares_limited =
        false;  // cells at constraint-limited vertices need no better shape than those outside

    // The sine that a new cell inside must reach.
    double needed_sine(const QualityThreshold& threshold) const {
        if (objective == Objective::radius_edge)
            return std::max(std::min(threshold.sine, least_sine), strict_least_sine);
        return std::max(threshold.sine + least_gain * (gain_offset + threshold.sine), least_sine);
    }

    // The sine that a new cell outside must reach: it may be as flat as one that it replaces.
    double needed_outside_sine(const QualityThreshold& threshold) const {
        return std::min(threshold.outside_sine, flat_outside);
    }

    // The largest (circumradius / shortest edge)^2 of a new cell inside.
    double allowed_squared_ratio(const QualityThreshold& threshold) const {
        return allowed_squared_ratio(threshold, max_radius_edge);
    }
    // The same with another bound than `max_radius_edge`.
    double allowed_squared_ratio(const QualityThreshold& threshold, double most) const {
        if (objective == Objective::least_sine) return std::max(threshold.squared_ratio, most * most);
        return std::max(std::min(ratio_gain * threshold.squared_ratio, strict_max_ratio * strict_max_ratio),
                        most * most);
    }

  private:
    // A change must raise the least sine by this share, so that ever smaller gains end. [1; 0 to 1; M
    // 2026-11, set not recorded]
    static constexpr double least_gain = 0.02;
    // This is added to the sine that the share is of, so that flat cells must gain something too. [1; > 0; M
    // 2026-11, set not recorded]
    static constexpr double gain_offset = 0.02;
    // A cell outside with a larger sine than this serves as room as well as any. [1; 0 to 1; M 2026-11, set
    // not recorded]
    static constexpr double flat_outside = 0.01;
    // A squared ratio must fall to this share of the largest before. [1; 0 to 1; M 2026-11, set not
    // recorded]
    static constexpr double ratio_gain = 0.8;
};

}  // namespace anatomesh
