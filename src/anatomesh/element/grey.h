// The mean grey value of an image within each tetrahedron.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct GreyOptions {
    double spacing_voxels = 0.5;  // between samples in a cell, in the image's smallest voxel step. [0.05, 10]
    std::uint32_t max_layers = 24;  // of samples in a cell; of n there are n (n + 1) (n + 2) / 6. [1, 100]
};

struct GreyStats {
    std::uint64_t samples = 0;
    std::uint64_t cells_outside = 0;     // no sample in the image: the value of the nearest voxels
    std::uint64_t cells_cut = 0;         // samples inside and outside: the mean of those inside
    double low = 0, high = 0, mean = 0;  // of the cells; the mean by volume
};

struct GreyResult {
    std::vector<double> values;  // per cell
    GreyStats stats;
};

// The image is taken as linear between the centres of its voxels, and it ends half a voxel beyond the last
// ones. Samples are the centres of a regular division of the cell: the mean is exact where the image is
// linear in the cell. Cells are taken with straight edges. Requires: a voxel at least. Errors: geometry
// E-ELM-001 no cell lies in the image; cancelled. Linear in the samples.
Result<GreyResult> grey_values(const TetMesh& mesh, const GreyImage& image, const GreyOptions& options,
                               RunContext& context);

}  // namespace anatomesh
