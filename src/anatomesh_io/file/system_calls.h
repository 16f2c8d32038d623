// SystemCalls: the few calls of the operating system by which files are written, so that tests can fail any
// of them.
#pragma once

#include <sys/types.h>

#include <cstddef>

namespace anatomesh {

// Each function behaves as the POSIX call of its name: -1 and errno on failure. Thread-safe.
class SystemCalls {
  public:
    virtual int open(const char* path, int flags, mode_t mode);
    virtual ssize_t write(int descriptor, const void* data, std::size_t size);
    virtual int truncate(int descriptor, off_t size);  // ftruncate
    virtual int fsync(int descriptor);
    virtual int close(int descriptor);
    virtual int rename(const char* from, const char* to);
    // Swaps two existing files in one step. EINVAL or ENOSYS where the file system cannot.
    virtual int exchange(const char* one, const char* other);
    virtual int unlink(const char* path);
    virtual ~SystemCalls() = default;

    static SystemCalls& real();
};

}  // namespace anatomesh
