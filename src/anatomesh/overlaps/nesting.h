// Which structures lie in which others, and so on which level of nesting each of them is.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/overlaps/relations.h"

namespace anatomesh {

// Notes, for each two structures, whether a slice between the first and the last one of the one draws the
// other one alone. Slices lie in their order where planes are parallel; elsewhere any slice counts as such a
// one. O(slices * structures^2).
void note_alone(const ContourSet& set, Relations& relations);

// Fills the relations of structures that no slice draws together. Each contour of one counts half on the
// next slice of the other below it, and half on the one above it. Requires: parallel slices, in order.
// Complexity: that of a SlicePartition for each such slice of two structures whose boxes overlap.
void relate_between(const ContourSet& set, const std::vector<std::uint32_t>& rank, Relations& relations);

// By structure, how many others it lies in, one in another. A structure lies in another one by rules 3, 4 and
// 6 of give_overlaps(). O(structures^2).
std::vector<std::uint32_t> levels_of(const Relations& relations, const std::vector<std::uint32_t>& rank);

// Whether a structure gives more than it may to one of another level that does not lie in it (rule 5 of
// give_overlaps()). O(structures^2).
bool gives_much_across(const Relations& relations, const std::vector<std::uint32_t>& rank,
                       const std::vector<std::uint32_t>& level);

// Whether any two of the structures have an area or a part of an outline in common, or may have between
// slices, of which none draws both. O(points + structures^2).
bool have_walls(const ContourSet& set, const std::vector<std::uint32_t>& structures,
                const Relations& relations);

}  // namespace anatomesh
