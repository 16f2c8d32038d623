// find_overlap: where structures that should exclude each other do not.
#pragma once

#include <cstdint>
#include <optional>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

struct StructureOverlap {
    std::uint32_t slice = 0, first = 0, second = 0;  // indices
    double area_mm2 =
        0;  // 0: their contours meet, or all but meet, elsewhere than in common vertices and segments
};

// Returns the first slice at which two structures have an area in common, or at which their contours meet as those of an
// exclusive set must not (slice_soundness.h), or all but do, with the two that have most in common; nothing for a set that may be
// exclusive. A slice whose contours cross too often counts as well. Requires: a kept contour set. Complexity: that of
// arrange() for slices of several structures.
std::optional<StructureOverlap> find_overlap(const ContourSet& set);

}  // namespace anatomesh
