// NiftiHeader: the fields of a NIfTI-1 or NIfTI-2 header, checked one by one. Internal to the room.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

struct NiftiHeader {
    std::endian order = std::endian::little;
    int version = 1;                        // 1 or 2
    bool single_file = true;                // false: the data lies in an .img file
    ClaimedLayout layout;                   // sizes at least 1; product not yet checked
    std::uint64_t data_begin = 0;           // byte of the file with the data
    double slope = 1, intercept = 0;        // finite; slope 0 was read as 1
    double millimetres = 1;                 // per spatial unit
    std::array<double, 3> pixdim{1, 1, 1};  // in the file's unit; usable when axis_has_pixdim
    std::array<bool, 3> axis_has_pixdim{true, true, true};
    double qfac = 1;
    int qform_code = 0, sform_code = 0;
    std::array<double, 3> quaternion{0, 0, 0};  // b, c, d
    Vec3 qoffset;
    std::array<std::array<double, 4>, 3> srow{};

    std::uint64_t header_bytes() const { return version == 1 ? 348 : 540; }
};

// Reads the header at the start of `bytes`, which may be just the start of the (inflated) file.
// Requires of the file, else error (input): E-NII-001 too short, -002 header size, -003 magic, -004 dim,
// -005 voxel type not supported, -006 bitpix against type, -007 vox_offset, -008 pixdim, -009 qfac,
// -010 scl_slope or scl_inter.
// Warns: W-NII-001 qfac 0, W-NII-002 unit unknown, W-NII-003 extension ignored.
Result<NiftiHeader> parse_nifti_header(std::span<const std::byte> bytes, const std::string& path,
                                       RunContext& context);

}  // namespace anatomesh
