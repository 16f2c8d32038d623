// What the network needs of DCMTK: its storage classes, and data sets in another transfer syntax.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anatomesh {

// The storage classes that are most in use, at most so many.
std::vector<std::string> usual_storage_classes(std::size_t most);

// The data set of an uncompressed DICOM file in implicit VR little endian. Nothing when DCMTK cannot make it.
// Requires: a file whose layout was checked.
std::optional<std::string> implicit_data_set(std::string_view file);

}  // namespace anatomesh
