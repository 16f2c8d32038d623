// ConflationStats: how much contours that were led through vertices of one another changed.
#pragma once

#include <cstdint>

namespace anatomesh {

class ConflatedContours;

struct ConflationStats {
    std::uint64_t vertices_taken = 0;  // by a contour from another structure's
    std::uint64_t vertices_moved = 0;  // onto another structure's
    std::uint64_t contours_changed = 0;
    std::uint32_t slices = 0;       // where something was changed
    std::uint32_t worst_slice = 0;  // the one with the widest change
    double widest_mm = 0;           // of a vertex, from the segment or the place it was drawn at
    double area_mm2 = 0;            // between contours as drawn and as led, over all slices and contours

    // What was changed on a slice.
    void add(const ConflatedContours& led, std::uint32_t slice);
};

}  // namespace anatomesh
