// SegmentClusters: the vertices from which the subsegments come, where they meet at acute angles.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/sample/contour_segments.h"

namespace anatomesh {

// An apex is a vertex at which subsegments meet at acute angles. From each one the straight subsegments come,
// one after the other - from a pole, where eight or more meet, those that lead on about straight -, up to the
// next apex: they are split on its shells (shell_point()), which all that come from it then have in common. A
// subsegment between two of them comes from neither; its halves do.
class SegmentClusters {
  public:
    // Of no subsegment.
    SegmentClusters() = default;
    // `acute`: as acute_vertices() of these. Complexity: O(n log n).
    SegmentClusters(std::span<const Vec3> points, const std::vector<Subsegment>& subsegments,
                    std::vector<std::uint32_t> acute);

    // The vertex from which the subsegment comes, if it comes from one.
    std::optional<std::uint32_t> of(const Subsegment& subsegment) const;

    // The subsegment is split: its halves at its first end and at its second one have these balls.
    void pass_on(const Subsegment& subsegment, std::uint32_t low, std::uint32_t high);

  private:
    bool is_apex(std::uint32_t vertex) const;

    std::vector<std::uint32_t> acute_;
    std::vector<std::uint32_t> of_ball_;  // or no_apex; empty: of none
};

}  // namespace anatomesh
