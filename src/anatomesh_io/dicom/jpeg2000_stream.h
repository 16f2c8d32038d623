// zeroed_stretch: bytes of a JPEG 2000 codestream that were lost.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace anatomesh {

// The decoder takes bytes of zero for empty packets and says nothing, so that a lost block of a file becomes other pixels.
// A tile has no more empty packets than it has packets, and coded data is next to random: a longer run of zeros
// is a lost stretch. Returns the length of the longest such run, in bytes; nothing where there is none, or where the main
// header cannot be read, which is the decoder's to tell. Other damage inside the coded data cannot be known: a
// codestream carries no sum of itself. O(bytes). Source: ISO/IEC 15444-1, annexes A (markers) and B (packets).
std::optional<std::uint64_t> zeroed_stretch(std::string_view codestream);

}  // namespace anatomesh
