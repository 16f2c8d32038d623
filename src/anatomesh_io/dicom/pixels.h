// Pixel data: where the frames of an object lie in its file, and their stored values.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/dicom/object.h"

namespace anatomesh {

// The frames of an object: all values uncompressed, or the fragments of each frame. Views into the data set.
struct PixelData {
    bool is_compressed = false;
    std::string_view values;
    std::vector<std::vector<std::string_view>> fragments;  // of each frame
};

// Checks lengths before anything is allocated. Errors: E-DCM-017 no pixel data; E-DCM-018 fewer bytes than
// the header claims; E-DCM-019 fragments that cannot be told to frames; E-DCM-020 a transfer syntax that
// cannot be decoded. Warns W-DCM-016 of bytes left over.
Result<PixelData> find_pixel_data(const DataSet& set, const PixelFormat& format, RunContext& context);

// Bytes of a frame as normalized values: BitsAllocated / 8 a pixel, at least 1.
std::size_t frame_bytes(const PixelFormat& format);

// Stored values to whole numbers of BitsAllocated bits in the machine's byte order: only the stored bits,
// with their sign. In place. Requires: 8, 16 or 32 bits allocated.
void normalize(std::span<std::byte> values, const PixelFormat& format, bool is_big_endian);

}  // namespace anatomesh
