// The entry of libFuzzer, for the target that ANATOMESH_FUZZ_TARGET names.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const auto* target = anatomesh::fuzz::find_target(ANATOMESH_FUZZ_TARGET);
    if (!target) std::abort();
    target->run({reinterpret_cast<const char*>(data), size});
    return 0;
}
