#include "anatomesh_io/file/durable_calls.h"

#include <fcntl.h>

#include <cerrno>

#include "anatomesh_io/file/uninterrupted.h"

namespace anatomesh {

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.find_last_of('/');
    if (slash == std::string::npos) return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

int close_checked(int descriptor, SystemCalls& calls) {
    return calls.close(descriptor) != 0 && errno != EINTR ? errno : 0;
}

int sync_checked(int descriptor, SystemCalls& calls) {
    return uninterrupted([&] { return calls.fsync(descriptor); }) == 0 ? 0 : errno;
}

int sync_folder(const std::string& folder, SystemCalls& calls) {
    const int descriptor =
        uninterrupted([&] { return calls.open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0); });
    if (descriptor < 0) return errno;
    const int synced = sync_checked(descriptor, calls);
    const int closed = close_checked(descriptor, calls);
    return synced != 0 && synced != EINVAL ? synced : closed;
}

}  // namespace anatomesh
