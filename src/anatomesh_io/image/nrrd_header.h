// NrrdHeader: the fields of a NRRD header, checked one by one. Internal to the room.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

enum class NrrdEncoding : std::uint8_t { raw, gzip, text };

struct NrrdHeader {
    VoxelType type = VoxelType::u8;
    std::optional<std::endian> order;
    NrrdEncoding encoding = NrrdEncoding::raw;
    std::vector<std::uint64_t> sizes;             // one per axis
    std::string space;                            // lower case; empty when absent
    std::vector<std::optional<Vec3>> directions;  // one per axis, nothing for "none"; or empty
    std::vector<double> spacings;                 // one per axis, NaN where it has none; or empty
    std::optional<Vec3> origin;
    double millimetres = 1;  // per unit of the space
    std::string data_file;   // empty: the data follows the header
    std::uint64_t line_skip = 0;
    std::int64_t byte_skip = 0;                              // -1: the data is the end of the file
    std::vector<std::pair<std::string, std::string>> pairs;  // key := value
    std::size_t data_begin = 0;  // byte of the file where an attached part would begin
};

// Errors (input): E-NRD-001 not a NRRD of version 1 to 5, -002 a line of the header is not readable or the
// header too long, -003 a field is repeated with another value, -004 a needed field is missing, -005 the
// value of a field is not usable, -006 voxel type not supported, -007 encoding not supported. Warns:
// W-NRD-001 unknown field, ignored; W-NRD-002 unit of the space unknown.
Result<NrrdHeader> parse_nrrd_header(std::span<const std::byte> bytes, const std::string& path,
                                     RunContext& context);

}  // namespace anatomesh
