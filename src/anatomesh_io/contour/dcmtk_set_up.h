// What every reader through DCMTK begins with, and its dictionary.
#pragma once

#include <cstdint>

namespace anatomesh {

// No log of its own; lists beyond 64 KiB, written as UN where the length field has 16 bits, are read as what
// they are. Once for the process, from any thread.
void set_up_dcmtk();

// Whether the dictionary holds the tag for a sequence.
bool is_sequence_tag(std::uint16_t group, std::uint16_t element);

}  // namespace anatomesh
