#include "anatomesh/base/version.h"

namespace anatomesh {

const char* library_version() {
    return ANATOMESH_VERSION;
}

}  // namespace anatomesh
