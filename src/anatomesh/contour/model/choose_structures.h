// choose_structures: some of the structures of a contour set, or of contours as a file gave them.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/model/raw_contours.h"

namespace anatomesh {

// Returns the contours of the structures `chosen`, in that order. Slices without them stay, because they say that
// the structures are not there. Requires: indices into set.structures, none twice. Guarantees: a kept set gives a
// kept set.
ContourSet choose_structures(const ContourSet& set, std::span<const std::uint32_t> chosen);

// This does the same with contours as a file gave them; points and planes stay as they are. O(contours).
RawContours choose_structures(const RawContours& raw, std::span<const std::uint32_t> chosen);

}  // namespace anatomesh
