#include "anatomesh_io/file/durable_calls.h"

#include <fcntl.h>
#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <ctime>
#include <system_error>

#include "anatomesh_io/file/uninterrupted.h"

namespace anatomesh {

namespace {

// One call writes no more than this: Linux writes at most 2^31 bytes by one. [bytes; 1 to 2^31; B]
constexpr std::size_t most_written_at_once = std::size_t{1} << 30;

// Keeps SIGXFSZ (file larger than RLIMIT_FSIZE) from ending the process: write() then gives EFBIG.
class FileSizeSignalGuard {
  public:
    FileSizeSignalGuard() {
        sigemptyset(&signals_);
        sigaddset(&signals_, SIGXFSZ);
        ::pthread_sigmask(SIG_BLOCK, &signals_, &before_);
    }
    ~FileSizeSignalGuard() {
        const timespec no_wait{};
        while (::sigtimedwait(&signals_, nullptr, &no_wait) < 0 && errno == EINTR) {
        }
        ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    FileSizeSignalGuard(const FileSizeSignalGuard&) = delete;
    FileSizeSignalGuard& operator=(const FileSizeSignalGuard&) = delete;

  private:
    sigset_t signals_{}, before_{};
};

}  // namespace

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.find_last_of('/');
    if (slash == std::string::npos) return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

std::string reason_of(int error_number) {
    return std::generic_category().message(error_number);
}

std::string advice_of(int error_number) {
    switch (error_number) {
        case ENOSPC:
            return "free space on the disk or write to another one";
        case EDQUOT:
            return "your disk quota is used up: free space or write elsewhere";
        case EFBIG:
            return "the file is larger than the limit for one file: raise it or write elsewhere";
        case EACCES:
        case EPERM:
        case EROFS:
            return "choose a folder that you may write to";
        case EMFILE:
        case ENFILE:
            return "too many files are open: close other programs or raise the limit";
        default:
            return "check the disk, or write to another one";
    }
}

int write_checked(int descriptor, std::string_view bytes, std::uint64_t& written, SystemCalls& calls) {
    const FileSizeSignalGuard guard;
    while (!bytes.empty()) {
        const std::size_t piece = std::min(bytes.size(), most_written_at_once);
        const ssize_t count = uninterrupted([&] { return calls.write(descriptor, bytes.data(), piece); });
        if (count <= 0) return count < 0 ? errno : EIO;
        written += static_cast<std::uint64_t>(count);
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return 0;
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
