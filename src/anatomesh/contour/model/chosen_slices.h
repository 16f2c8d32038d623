// chosen_slices: a contour set with some of its slices.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Returns these slices of the set, and of what overlapped in it, in the order given. Structures keep their numbers,
// also those that are no longer drawn. Complexity: O(points).
ContourSet chosen_slices(const ContourSet& set, std::span<const std::uint32_t> slices);

// Returns the set without the contours marked, at their indices; all slices stay. Requires: nothing overlaps in it.
// Complexity: O(points).
ContourSet without_contours(const ContourSet& set, std::span<const std::uint8_t> marked);

// Returns the slices offset, offset + every, ... of a set of parallel slices. Requires: every >= 1. O(points).
ContourSet every_nth_slice(const ContourSet& set, std::uint32_t every, std::uint32_t offset);

// Returns by slice whether one of its `names` is one of those wanted. Case and blanks do not count where no name is
// equal with them. Error: usage E-CON-010 no slice is called so, with the names that there are.
Result<std::vector<std::uint8_t>> named_slices(std::span<const std::vector<std::string>> names,
                                               std::span<const std::string> wanted, const std::string& file);

// Returns the set without the slices of these names; with no names, the set. Errors: as named_slices(), and usage
// E-CON-011 no slice is left.
Result<ContourSet> without_slices(ContourSet set, std::span<const std::string> names);

Error no_slice_left(const std::string& file);

}  // namespace anatomesh
