// find_sparse_structures: structures of a label map that are painted on some slices alone, with nothing between.
//
// Painting every fifth slice and filling between them later is usual (3D Slicer, ITK-SNAP). Taken for all that
// there is, such a structure becomes a plate for each painted slice. A row of real plates looks the same, so
// nobody but the user knows which it is.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/image/image.h"

namespace anatomesh {

struct SparseStructure {
    std::uint32_t structure = 0;  // index into LabelMap::structures
    std::uint32_t axis = 0;       // the voxel axis that its slices follow
    std::uint32_t slices = 0;     // that it is on
    std::uint32_t step = 0;       // from one to the next, in slices, in the median
    double painted_mm3 = 0;       // of its voxels
    double joined_mm3 = 0;        // with what lies between the slices, by the trapezoidal rule
};

// A structure is sparse along an axis if three of its slices or more, and 60 % of all, have no neighbour with it, and
// half of those that follow each other overlap by half of the smaller one, seen along the axis. Of
// several such axes the one with the fewest slices is taken. In the order of the structures.
// Complexity: O(voxels), and structures x slices in memory (bits).
std::vector<SparseStructure> find_sparse_structures(const LabelMap& labels);

}  // namespace anatomesh
