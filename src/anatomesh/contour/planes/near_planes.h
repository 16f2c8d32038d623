// near_planes: which planes of a stack, near each other beside its spacing, are one slice of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/contour/planes/plane_grouping.h"

namespace anatomesh {

// Contours known to lie on one plane, at `offset` along the normal of a stack.
struct PositionedCluster {
    double offset = 0;
    double noise = 0;          // root mean square distance of their points from their plane
    bool is_declared = false;  // the file says which plane it is: never joined
    std::vector<std::uint32_t> contours;
};

// The runs [first, last) of `stack`, clusters in the order of their offsets, that are one slice. Such a run
// spans no more than `most_mm` and 2 / 5 of the gap on either side: what is near is told by the stack's own
// spacing. One of two things must show it to be one slice:
// - its planes differ by no more than twice the noise of their points, and read as one slice its structures
//   differ from those of the slices beside it by no more than read as several;
// - read as one slice its structures differ from those beside it by less than half of what they do read as
//   several, there or in all such runs of the stack together: an outline and its hole, drawn at two heights,
//   make a tube; read as several slices they make a stack of discs, large and small in turn. Slices of a
//   solid at two heights stay two. At an end of the stack, only if a run within it shows the same.
// Planes that draw no structure in common are one where they differ by no more than a file rounds places.
// How much two slices differ: the area in one of them alone, as a share of both areas; regions by the
// even-odd rule, areas by scan lines. Contours on two of the planes that differ by less than a tenth of their
// area are two slices of one thing. Where the set has planes of other directions, too (not `is_whole_set`), contours
// that lie beside each other in the plane show nothing, because they may be legs of one bent tube: such planes are
// one only within the noise of their points. Complexity: O(stack), and for each run that is near enough O(its points
// and those beside it, times the scan lines they cross), its contours of one structure in pairs.
std::vector<std::pair<std::size_t, std::size_t>> runs_of_one_slice(std::span<const PositionedCluster> stack,
                                                                   std::span<const ContourToPlace> contours,
                                                                   Vec3 normal, double most_mm,
                                                                   bool is_whole_set);

}  // namespace anatomesh
