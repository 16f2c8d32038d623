// Distance between two surfaces, both ways.
#pragma once

#include <cstdint>

#include "anatomesh/base/run_context.h"
#include "anatomesh/mesh/model/box_tree.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

// mm. min and max also over the vertices; mean, RMS and the 95th percentile over samples spread evenly by
// area.
struct DistanceStats {
    double min = 0, mean = 0, rms = 0, p95 = 0, max = 0;
};

struct SurfaceDistance {
    DistanceStats a_to_b, b_to_a;
    DistanceStats both;  // of all samples of both ways; its max is the Hausdorff distance of what was sampled
    std::uint64_t samples_a = 0, samples_b = 0;
};

struct SurfaceDistanceOptions {
    std::uint64_t samples = 100'000;  // per surface, besides its vertices. [1, 1e8]
};

// The nearest point of a surface. Immutable; queries are thread-safe.
class ClosestPoint {
  public:
    // Requires: at least one triangle, and that the surface outlives this.
    explicit ClosestPoint(const SurfaceMesh& surface);

    // Distance from p to the closed triangles. Complexity: O(log n) for a surface that is not far away.
    double distance(Vec3 p) const;

  private:
    const SurfaceMesh& surface_;
    BoxTree tree_;
};

// Points spread by area: sample k of n lies in the triangle at share (k + 1/2) / n of the total area, at the
// k-th point of a low-discrepancy sequence (Roberts' R2). Deterministic. Requires: a total area above 0.
std::vector<Vec3> area_samples(const SurfaceMesh& surface, std::uint64_t count);

// Errors: input E-MEA-001 a surface has no triangle, E-MEA-002 a coordinate is not finite, E-MEA-003 a
// surface has no area; usage E-MEA-004 samples out of range; cancelled. Same figures for any number of
// threads.
Result<SurfaceDistance> surface_distance(const SurfaceMesh& a, const SurfaceMesh& b,
                                         const SurfaceDistanceOptions& options, RunContext& context);

}  // namespace anatomesh
