// EarlierMaps: distance maps of fields made earlier, by the outlines that they are of.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "anatomesh/field/slice/distance_map.h"

namespace anatomesh {

// A number that equal edges have in common, and others hardly ever. O(edges).
std::uint64_t fingerprint_of(std::span<const Edge2> edges);

// Whether the coordinates of all edges have the same bits. O(edges).
bool have_equal_bits(std::span<const Edge2> a, std::span<const Edge2> b);

// Finds the map whose edges are the same, bit for bit and in order, so that its values are those of a new one.
class EarlierMaps {
  public:
    // Where a map comes from: the number of its field and its place there.
    struct Entry {
        std::uint64_t fingerprint;  // of its edges
        const DistanceMap* map;
        std::uint32_t field, place;
    };

    EarlierMaps() = default;
    // O(n log n).
    explicit EarlierMaps(std::vector<Entry> entries);

    // The first of them; null where there is none. O(edges + log n).
    const Entry* find(std::uint64_t fingerprint, std::span<const Edge2> edges, double limit) const;

  private:
    std::vector<Entry> entries_;  // rising by fingerprint, then as they were given
};

}  // namespace anatomesh
