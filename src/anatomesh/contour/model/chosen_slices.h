// chosen_slices: a contour set with some of its slices.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Of the set, and of what overlapped in it; structures keep their numbers, also those that are no longer
// drawn. Slices come in the order given. Complexity: O(points).
ContourSet chosen_slices(const ContourSet& set, std::span<const std::uint32_t> slices);

// The slices offset, offset + every, ... of a set of parallel slices. Requires: every >= 1. O(points).
ContourSet every_nth_slice(const ContourSet& set, std::uint32_t every, std::uint32_t offset);

// By slice, whether one of its `names` is one of those wanted; case and blanks do not count where none is the
// same with them. Error: usage
// E-CON-010 no slice is called so, with the names that there are.
Result<std::vector<std::uint8_t>> named_slices(std::span<const std::vector<std::string>> names,
                                               std::span<const std::string> wanted, const std::string& file);

// The set without the slices of these names, if any. Errors: as named_slices(); usage E-CON-011 none is left.
Result<ContourSet> without_slices(ContourSet set, std::span<const std::string> names);

Error no_slice_left(const std::string& file);

}  // namespace anatomesh
