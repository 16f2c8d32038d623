// uninterrupted: a system call that a signal interrupted is made again.
#pragma once

#include <cerrno>

namespace anatomesh {

// `call` returns a number below 0 and sets errno where it fails, as system calls do. It is called until it ends otherwise than
// by EINTR, and what it returned then is returned.
template <class Call>
auto uninterrupted(const Call& call) {
    for (;;) {
        const auto result = call();
        if (result >= 0 || errno != EINTR) return result;
    }
}

}  // namespace anatomesh
