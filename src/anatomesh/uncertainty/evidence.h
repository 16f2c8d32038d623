// ContourEvidence: how far a point is from what was drawn of a structure.
#pragma once

#include <cstdint>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/measure/hausdorff.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// The contour segments of one structure. Immutable; queries are thread-safe.
class ContourEvidence {
  public:
    ContourEvidence(const ContourSet& set, std::uint32_t structure);
    ContourEvidence(const ContourEvidence&) = delete;
    ContourEvidence& operator=(const ContourEvidence&) = delete;

    bool empty() const { return segments_.triangles.empty(); }

    // mm from p to the nearest segment, at most `reach`. Complexity: O(log n) near the contours.
    double distance(Vec3 p, double reach) const;

  private:
    SurfaceMesh segments_;  // each as a triangle without area
    ClosestPoint nearest_;
};

}  // namespace anatomesh
