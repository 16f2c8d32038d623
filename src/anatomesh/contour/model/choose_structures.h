// Some of the structures of a contour set.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// The contours of the structures `chosen`, in that order. The slices without them stay: they say that they
// are not there. Requires: indices into set.structures, none twice. Guarantees: a kept set gives a kept set.
ContourSet choose_structures(const ContourSet& set, std::span<const std::uint32_t> chosen);

}  // namespace anatomesh
