// SlicePartition: the faces into which all contours of a slice divide its plane, and the structure that each
// face belongs to.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/overlay/arrangement.h"
#include "anatomesh/overlaps/relations.h"

namespace anatomesh {

// A face belongs to the structure of least rank of those that are drawn there, by the even-odd rule.
class SlicePartition {
  public:
    // Requires: the set and the ranks, one a structure, outlive this and stay as they are.
    SlicePartition(const ContourSet& set, const Slice& slice, const std::vector<std::uint32_t>& rank)
        : set_(set), slice_(slice), rank_(rank) {}

    // Makes the faces; false where the contours cross too often. O((n + k) log n), k crossings.
    bool arrange_contours();

    // Adds the outlines of what belongs to a structure to `raw`, in the plane of that number. Returns how
    // much of the structure's drawn area does not belong to it, mm^2. Loops narrower than 1e-3 mm are left
    // out. Requires: arrange_contours(). O(n log n).
    double add_region(std::uint32_t structure, std::int32_t plane, RawContours& raw) const;

    // Adds this slice's areas and lengths to those of the structures' relations. Requires:
    // arrange_contours(). O(edges * structures + structures^2).
    void add_to(Relations& relations) const;

  private:
    struct Face {
        std::uint32_t owner = 0;
        std::vector<std::uint32_t> drawn;  // all structures there
    };

    Face face_of(const Winding& winding) const;
    bool draws(std::uint32_t face, std::uint32_t structure) const;

    const ContourSet& set_;
    const Slice& slice_;
    const std::vector<std::uint32_t>& rank_;
    std::vector<std::uint32_t> structures_;  // per ring
    std::optional<Arrangement> graph_;
    std::vector<Face> faces_;  // per winding
};

}  // namespace anatomesh
