// RoutedContour: a contour that runs along the surface of a mesh beside where it is drawn.
#pragma once

#include <cstdint>
#include <vector>

namespace anatomesh {

struct RoutedContour {
    std::uint32_t contour = 0;            // its index in the contour set
    std::vector<std::uint32_t> vertices;  // of the mesh, all, in order
    std::uint64_t segments = 0;           // drawn segments that were missed before and are not any more
    double farthest_mm = 0;               // of it from what was drawn, and of that from it
    friend bool operator==(const RoutedContour&, const RoutedContour&) = default;
};

}  // namespace anatomesh
