// keep_largest: the largest connected pieces of every structure of a label map.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/image/image.h"

namespace anatomesh {

struct ComponentStats {
    struct OfStructure {
        std::uint32_t pieces = 0, pieces_kept = 0;
        std::uint64_t voxels = 0, voxels_kept = 0;
    };
    std::vector<OfStructure> structures;  // parallel to LabelMap::structures
};

// Sets all voxels of a structure outside its `count` largest pieces to 0. A piece is 26-connected (voxels
// that share a face, an edge or a corner) over the whole image; of equally large ones the one that comes
// first in voxel order is kept. Requires: count >= 1; every label is at most structures.size(). Complexity:
// linear in the voxels. Follows: union-find on runs, He, Chao and Suzuki, IEEE TIP 17, 2008.
ComponentStats keep_largest(LabelMap& labels, std::uint32_t count);

}  // namespace anatomesh
