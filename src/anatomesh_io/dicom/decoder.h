// decode_frame: one compressed frame into its values. The door to GDCM's decoders.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh_io/dicom/object.h"

namespace anatomesh {

// Whether frames of this transfer syntax can be decoded: JPEG (baseline, extended, lossless), JPEG-LS, JPEG
// 2000, RLE.
bool can_decode(const std::string& transfer_syntax);

// Decodes the fragments of one frame to `out`, which has the size of the frame as stored uncompressed, little
// endian. Returns an empty text, or why it failed: what the decoder refuses or warns of, and stretches of zeros in
// JPEG 2000 (jpeg2000_stream.h). Not all damage shows. May crash on damaged data, and points the standard error stream
// elsewhere for a while: to be called by run_in_child().
std::string decode_frame(const std::vector<std::string_view>& fragments, const std::string& transfer_syntax,
                         const PixelFormat& format, std::span<std::byte> out);

}  // namespace anatomesh
