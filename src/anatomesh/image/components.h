// keep_largest and pieces_between: connected components ("pieces") of the structures of a label map.
//
// A piece is 26-connected, so its voxels share a face, an edge or a corner, over the whole image. Pieces are found by
// union-find on runs (He, Chao and Suzuki, IEEE TIP 17, 2008).
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

// Sets all voxels of a structure outside its `count` largest pieces to 0. Of equally large ones the one that comes first
// in voxel order is kept. Requires: count >= 1; every label is at most structures.size(). Complexity: linear in the
// voxels.
ComponentStats keep_largest(LabelMap& labels, std::uint32_t count);

// The kept slices: every `every`th one along a voxel axis, from `offset` on.
struct KeptSlices {
    std::uint32_t axis = 2, every = 1, offset = 0;
};

struct MissedPieces {
    std::uint32_t pieces = 0;
    std::uint64_t voxels = 0, largest = 0;  // of all of them, of the largest
};

// Returns, by structure, its pieces of `least_voxels` or more that lie wholly between the kept slices. Who looks at the
// kept slices alone never learns of them. Requires and complexity: as above.
std::vector<MissedPieces> pieces_between(const LabelMap& labels, const KeptSlices& kept,
                                         std::uint64_t least_voxels);

}  // namespace anatomesh
