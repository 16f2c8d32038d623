#include "anatomesh_io/file/system_calls.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>

namespace anatomesh {

int SystemCalls::open(const char* path, int flags, mode_t mode) {
    return ::open(path, flags, mode);
}
ssize_t SystemCalls::write(int descriptor, const void* data, std::size_t size) {
    return ::write(descriptor, data, size);
}
int SystemCalls::truncate(int descriptor, off_t size) {
    return ::ftruncate(descriptor, size);
}
int SystemCalls::fsync(int descriptor) {
    return ::fsync(descriptor);
}
int SystemCalls::close(int descriptor) {
    return ::close(descriptor);
}
int SystemCalls::rename(const char* from, const char* to) {
    return std::rename(from, to);
}
int SystemCalls::exchange(const char* one, const char* other) {
    return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, one, AT_FDCWD, other, RENAME_EXCHANGE));
}
int SystemCalls::unlink(const char* path) {
    return ::unlink(path);
}

SystemCalls& SystemCalls::real() {
    static SystemCalls calls;
    return calls;
}

}  // namespace anatomesh
