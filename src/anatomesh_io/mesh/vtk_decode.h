// How the arrays of a VTK XML file are packed: numbers as text, base64, zlib blocks. Used by the reader only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh {

// Says of the file what its arrays need to be read.
struct VtkEncoding {
    std::string path;  // for messages
    bool little_endian = true;
    bool wide_header = false;  // UInt64 instead of UInt32
    bool compressed = false;
    std::uint64_t file_bytes = 0;
    InputLimits limits;
};

// Reads `array.bytes` (name, type and components are set) from numbers separated by blanks.
Status decode_ascii(VtkArray& array, std::string_view text, const VtkEncoding& encoding);

// Reads `array.bytes` from `data`, which begins with the array's header and may go on beyond its end.
// `inflated` counts the bytes of all arrays so far, against the limits.
Status decode_binary(VtkArray& array, std::string_view data, bool base64, const VtkEncoding& encoding,
                     std::uint64_t& inflated);

Error vtk_error(const char* code, std::string message, const std::string& path,
                const std::string& array = {});

}  // namespace anatomesh
