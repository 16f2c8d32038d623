#include "anatomesh_io/file/set_journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "anatomesh_io/file/durable_calls.h"
#include "anatomesh_io/file/uninterrupted.h"

namespace anatomesh {

namespace {

// Of a journal: more is none of ours. [bytes; >= 1; B]
constexpr std::size_t most_bytes = std::size_t{1} << 20;
// The last field of a journal that is whole.
constexpr std::string_view whole = "end of the set";

std::optional<struct stat> state_of(const std::string& path) {
    struct stat state {};
    if (uninterrupted([&] { return ::lstat(path.c_str(), &state); }) != 0) return std::nullopt;
    return state;
}

// Which file it is, and in which state; a name without a file has one as well.
std::string identity(const std::string& path) {
    const std::optional<struct stat> state = state_of(path);
    if (!state) return "none";
    return fmt::format("{} {} {} {}.{}", state->st_dev, state->st_ino, state->st_size, state->st_mtim.tv_sec,
                       state->st_mtim.tv_nsec);
}

bool is_of_this_user(const struct stat& state) {
    return S_ISREG(state.st_mode) && state.st_uid == ::geteuid();
}

int write_and_sync(int descriptor, std::string_view bytes, SystemCalls& calls) {
    std::uint64_t written = 0;
    const int failed = write_checked(descriptor, bytes, written, calls);
    return failed != 0 ? failed : sync_checked(descriptor, calls);
}

// Nothing where it is none of this user's.
std::optional<std::string> content_of_journal(const std::string& path) {
    const int descriptor =
        uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW); });
    if (descriptor < 0) return std::nullopt;
    std::optional<std::string> bytes;
    struct stat state {};
    if (uninterrupted([&] { return ::fstat(descriptor, &state); }) == 0 && is_of_this_user(state) &&
        static_cast<std::size_t>(state.st_size) <= most_bytes) {
        bytes.emplace(static_cast<std::size_t>(state.st_size), '\0');
        const ssize_t got = uninterrupted([&] { return ::read(descriptor, bytes->data(), bytes->size()); });
        bytes->resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    }
    ::close(descriptor);
    return bytes;
}

std::vector<std::string> fields_of(std::string_view bytes) {
    std::vector<std::string> fields;
    for (std::size_t end = bytes.find('\0'); end != std::string_view::npos; end = bytes.find('\0')) {
        fields.emplace_back(bytes.substr(0, end));
        bytes.remove_prefix(end + 1);
    }
    return fields;
}

bool is_temporary(const std::string& path, std::string_view prefix) {
    const std::string_view name = std::string_view(path).substr(path.find_last_of('/') + 1);
    const std::optional<struct stat> state = state_of(path);
    return name.starts_with(prefix) && state && is_of_this_user(*state);
}

// Of each output: names, and which files they were.
struct Entry {
    std::string temporary, target, fresh, before;
};

void finish_output(const Entry& entry, std::string_view prefix, SystemCalls& calls) {
    if (!is_temporary(entry.temporary, prefix)) return;  // it has its name
    const bool is_fresh = identity(entry.temporary) == entry.fresh;
    if (is_fresh && identity(entry.target) == entry.before &&
        uninterrupted([&] { return calls.rename(entry.temporary.c_str(), entry.target.c_str()); }) == 0) {
        sync_folder(folder_of(entry.target), calls);
        return;
    }
    calls.unlink(entry.temporary.c_str());
}

}  // namespace

int write_journal(const std::string& path, const std::vector<PendingOutput>& outputs, SystemCalls& calls) {
    std::string bytes;
    for (const PendingOutput& output : outputs) {
        for (const std::string& field :
             {output.temporary, output.target, identity(output.temporary), identity(output.target)}) {
            bytes += field;
            bytes += '\0';
        }
    }
    bytes += whole;
    bytes += '\0';
    const int descriptor = uninterrupted(
        [&] { return calls.open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600); });
    if (descriptor < 0) return errno;
    int failed = write_and_sync(descriptor, bytes, calls);
    const int closed = close_checked(descriptor, calls);
    if (failed == 0) failed = closed;
    if (failed == 0) failed = sync_folder(folder_of(path), calls);
    if (failed != 0) calls.unlink(path.c_str());
    return failed;
}

void finish_journal(const std::string& path, std::string_view prefix, SystemCalls& calls) {
    const std::optional<std::string> bytes = content_of_journal(path);
    if (!bytes) return;
    const std::vector<std::string> fields = fields_of(*bytes);
    // Fields of an output. [fields; 4; D write_journal()]
    constexpr std::size_t of_each = 4;
    if (fields.size() % of_each == 1 && fields.back() == whole) {
        for (std::size_t n = 0; n + of_each < fields.size(); n += of_each)
            finish_output({fields[n], fields[n + 1], fields[n + 2], fields[n + 3]}, prefix, calls);
    }
    calls.unlink(path.c_str());
}

}  // namespace anatomesh
