// Whether two contour sets are one, bit for bit.
#pragma once

#include <cstddef>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh::fixtures {

inline bool same(const ContourSet& a, const ContourSet& b) {
    if (a.points != b.points || a.contours.size() != b.contours.size() ||
        a.slices.size() != b.slices.size()) {
        return false;
    }
    for (std::size_t c = 0; c < a.contours.size(); ++c) {
        if (a.contours[c].structure != b.contours[c].structure ||
            a.contours[c].slice != b.contours[c].slice ||
            a.contours[c].first_point != b.contours[c].first_point) {
            return false;
        }
    }
    return true;
}

}  // namespace anatomesh::fixtures
