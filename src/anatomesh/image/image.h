// GreyImage and LabelMap: voxel images placed in space.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/structure.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// The centre of voxel (i, j, k) lies at origin + i step[0] + j step[1] + k step[2], in LPS millimetres. The steps are
// linearly independent; they need not be orthogonal (gantry tilt) nor right-handed.
struct ImageGeometry {
    std::array<std::uint32_t, 3> size{0, 0, 0};
    Vec3 origin;
    std::array<Vec3, 3> step{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

    std::size_t voxel_count() const { return std::size_t{size[0]} * size[1] * size[2]; }
    std::size_t index(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
        return (std::size_t{k} * size[1] + j) * size[0] + i;
    }
    Vec3 position(double i, double j, double k) const {
        return origin + i * step[0] + j * step[1] + k * step[2];
    }
};

// Grey values; i runs fastest, and voxels.size() == geometry.voxel_count().
struct GreyImage {
    ImageGeometry geometry;
    std::vector<float> voxels;
    std::string source;  // the file, as the user named it
};

// Each voxel is 0 outside every structure, else 1 + an index into structures.
struct LabelMap {
    ImageGeometry geometry;
    std::vector<std::uint16_t> voxels;
    std::vector<Structure> structures;  // number = the label value in the file; sorted by number
    std::string source;
    // Whether the image itself ends before the first and after the last slice, so that a structure there may be
    // cut; else slices beyond are empty.
    std::array<bool, 2> ends_at_image = {true, true};
};

}  // namespace anatomesh
