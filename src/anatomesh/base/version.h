// The library's version, as it stands in every model that it makes.
#pragma once

namespace anatomesh {

// "0.1.0".
const char* library_version();

}  // namespace anatomesh
