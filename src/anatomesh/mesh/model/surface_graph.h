// SurfaceGraph: the vertices of a surface and the edges between them, to go along.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

class SurfaceGraph {
  public:
    // Requires: points outlive this. Complexity: O(points + triangles).
    SurfaceGraph(std::span<const Vec3> points, std::span<const Triangle> triangles);

    // Those that edges join to v, each once for every triangle at the edge.
    std::span<const std::uint32_t> neighbors(std::uint32_t v) const {
        return {neighbors_.data() + start_[v], start_[v + 1] - start_[v]};
    }

    // Whether edges lead from a to b along the straight line, each step onwards to the nearest vertex on it:
    // none further from it than 1e-6 of its length and 1e-12 of the coordinates' size.
    bool chain(std::uint32_t a, std::uint32_t b) const;

  private:
    std::span<const Vec3> points_;
    std::vector<std::size_t> start_;  // where in neighbors_ those of each vertex start
    std::vector<std::uint32_t> neighbors_;
};

}  // namespace anatomesh
