// select_structures: a label map with some of its structures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/image/image.h"

namespace anatomesh {

// Returns the number of voxels of each structure, parallel to LabelMap::structures. O(voxels).
std::vector<std::uint64_t> count_voxels(const LabelMap& labels);

// Keeps the structures with these indices, in the order they have in the label map; the voxels of all others
// become 0. An index may come more than once.
// Requires: every index < structures.size(); every label is at most structures.size(). Complexity: linear.
void select_structures(LabelMap& labels, std::span<const std::uint32_t> keep);

}  // namespace anatomesh
