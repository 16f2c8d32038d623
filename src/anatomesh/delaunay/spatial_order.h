// spatial_order: an order of insertion in which neighbours are near in space, in random rounds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Rounds of points, each about eight times the one before and along a Hilbert curve of its own: a search that
// starts at the point inserted before is short, and the order is random enough for the expected size of every
// intermediate tetrahedralization (Amenta, Choi and Rote, SoCG 2003).
struct SpatialOrder {
    std::vector<std::uint32_t> order;         // a permutation of the indices of the points
    std::vector<std::uint32_t> round_begins;  // in `order`; the last is its size
};

// `known`: points that are there already; rounds much smaller than that are of no use and not made.
// Guarantees: a function of the points and `known` alone, whatever the order of the points and `threads`;
// equal points follow each other in one round, by index. Requires: finite points, fewer than 2^31.
// Complexity: O(n), O(n log n) for points that crowd in few places. Follows: Hamilton, Compact Hilbert
// Indices, Dalhousie University CS-2006-07 (the curve); Marsaglia's and Vigna's split mix for the rounds.
SpatialOrder spatial_order(std::span<const Vec3> points, std::size_t known, int threads);

}  // namespace anatomesh
