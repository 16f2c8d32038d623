// What the network needs of DCMTK: its dictionary, and data sets in another transfer syntax.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anatomesh {

// Whether the dictionary holds the tag for a sequence.
bool is_sequence_tag(std::uint16_t group, std::uint16_t element);

// The storage classes that are most in use, at most so many.
std::vector<std::string> usual_storage_classes(std::size_t most);

// The data set of an uncompressed DICOM file in implicit VR little endian. Nothing when DCMTK cannot make it.
// Requires: a file whose layout was checked.
std::optional<std::string> implicit_data_set(std::string_view file);

}  // namespace anatomesh
