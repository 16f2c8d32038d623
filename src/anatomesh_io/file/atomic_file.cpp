#include "anatomesh_io/file/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "anatomesh_io/file/durable_calls.h"
#include "anatomesh_io/file/set_journal.h"
#include "anatomesh_io/file/uninterrupted.h"

namespace anatomesh {

namespace {

constexpr std::string_view temporary_prefix = ".anatomesh-";
constexpr std::string_view temporary_suffix = ".tmp";
// So many names are tried for a temporary file before giving up: others may be left by runs that were killed.
// [names; >= 1; B]
constexpr int max_temporaries = 10'000;

Error file_error(const char* code, std::string message, const std::string& path, std::string next_step = {}) {
    Error error{ErrorKind::file, code, std::move(message), {}, std::move(next_step)};
    error.place.file = path;
    return error;
}

// Tells this machine (and container) from others that share the folder, so that only own process ids are
// judged.
std::string machine_tag() {
    char host[256] = {};
    ::gethostname(host, sizeof host - 1);
    char space[64] = {};
    const ssize_t length = ::readlink("/proc/self/ns/pid", space, sizeof space - 1);
    std::uint32_t hash = 2166136261u;  // FNV-1a
    const auto mix = [&](std::string_view text) {
        for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
    };
    mix(host);
    mix({space, static_cast<std::size_t>(std::max<ssize_t>(length, 0))});
    char digits[8];
    const char* end = std::to_chars(digits, digits + sizeof digits, hash, 16).ptr;
    return {digits, static_cast<std::size_t>(end - digits)};
}

std::string own_prefix() {
    return std::string(temporary_prefix) + machine_tag() + "-";
}

// The process that made a temporary file or a journal of this machine, from ".anatomesh-<machine>-<pid>-<n><suffix>".
std::optional<pid_t> owner_of(std::string_view name, std::string_view prefix, std::string_view suffix) {
    if (!name.starts_with(prefix) || !name.ends_with(suffix)) return std::nullopt;
    name.remove_prefix(prefix.size());
    pid_t owner = 0;
    const auto [end, failure] = std::from_chars(name.data(), name.data() + name.size(), owner);
    if (failure != std::errc() || owner <= 0 || end == name.data() + name.size() || *end != '-')
        return std::nullopt;
    return owner;
}

// What killed runs of this machine left in a folder, by the ending of the names.
std::vector<std::string> left_behind(const std::string& folder, std::string_view suffix) {
    const std::string prefix = own_prefix();
    std::vector<std::string> left;
    std::error_code failure;
    std::filesystem::directory_iterator entry(folder, failure), end;
    while (!failure && entry != end) {
        const auto owner = owner_of(entry->path().filename().string(), prefix, suffix);
        if (owner && ::kill(*owner, 0) != 0 && errno == ESRCH) left.push_back(entry->path().string());
        entry.increment(failure);
    }
    std::sort(left.begin(), left.end());
    return left;
}

// Outputs that were about to get their names get them; other temporary files are removed. Best effort: what cannot be
// removed does no harm.
void clean_up(const std::string& folder, SystemCalls& calls) {
    for (const std::string& journal : left_behind(folder, journal_suffix))
        finish_journal(journal, own_prefix(), calls);
    for (const std::string& temporary : left_behind(folder, temporary_suffix))
        calls.unlink(temporary.c_str());
}

struct Target {
    std::string file, folder;
    mode_t mode = 0666;  // of the file to be replaced
    bool exists = false;
};

bool too_long(const std::string& path) {
    const std::size_t slash = path.find_last_of('/');
    const std::size_t name = slash == std::string::npos ? path.size() : path.size() - slash - 1;
    // The temporary name must fit as well.
    return path.size() - name + std::max<std::size_t>(name, 64) >= PATH_MAX || name > NAME_MAX;
}

Status check_folder(const std::string& folder, const std::string& path) {
    struct stat status {};
    if (uninterrupted([&] { return ::stat(folder.c_str(), &status); }) != 0) {
        const int why = errno;
        if (why == ENOENT || why == ENOTDIR) {
            return file_error("E-FILE-001", "the folder " + folder + " does not exist", path,
                              "create the folder, or choose another one");
        }
        return file_error("E-FILE-002", "the folder cannot be used: " + reason_of(why), path, advice_of(why));
    }
    if (!S_ISDIR(status.st_mode)) {
        return file_error("E-FILE-001", folder + " is not a folder", path, "choose a folder");
    }
    // A folder without any write permission is meant to stay as it is, even when the user is root.
    if ((status.st_mode & 0222) == 0 || ::access(folder.c_str(), W_OK | X_OK) != 0) {
        return file_error("E-FILE-002", "the folder " + folder + " is read-only", path, advice_of(EACCES));
    }
    return Nothing{};
}

Result<Target> find_target(const std::string& path) {
    if (path.empty())
        return file_error("E-FILE-011", "the name of the output is empty", path, "give the name of a file");
    if (too_long(path)) {
        return file_error("E-FILE-005", "the path is too long (" + std::to_string(path.size()) + " bytes)",
                          path.substr(0, 100) + "...", "choose a shorter one");
    }
    Target target;
    target.file = path;
    std::error_code failure;
    if (std::filesystem::is_symlink(path, failure)) {
        const auto followed = std::filesystem::weakly_canonical(path, failure);
        if (!failure) target.file = followed.string();
    }
    struct stat status {};
    if (uninterrupted([&] { return ::stat(target.file.c_str(), &status); }) == 0) {
        target.exists = true;
        target.mode = status.st_mode & 0777;
        if (S_ISDIR(status.st_mode)) {
            return file_error("E-FILE-004", "the output is a folder", path, "name a file in it");
        }
        if (!S_ISREG(status.st_mode)) {
            return file_error("E-FILE-006", "the output exists and is not a regular file", path,
                              "name another file");
        }
        if ((status.st_mode & 0222) == 0 || ::access(target.file.c_str(), W_OK) != 0) {
            return file_error("E-FILE-003", "the file exists and is read-only", path,
                              "make it writable or name another file");
        }
    } else if (target.file.back() == '/') {
        return file_error("E-FILE-004", "the output is a folder", path, "name a file in it");
    }
    target.folder = folder_of(target.file);
    ANATOMESH_CHECK_STATUS(check_folder(target.folder, path));
    return target;
}

struct Temporary {
    std::string name;
    int descriptor = -1;
};

Result<Temporary> create_temporary(const Target& target, const std::string& path, SystemCalls& calls) {
    const std::string stem =
        (target.folder == "/" ? "" : target.folder) + "/" + own_prefix() + std::to_string(::getpid()) + "-";
    int why = EEXIST;
    for (int number = 0; number < max_temporaries; ++number) {
        Temporary temporary;
        temporary.name = stem + std::to_string(number) + std::string(temporary_suffix);
        do {
            temporary.descriptor = calls.open(temporary.name.c_str(),
                                              O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
        } while (temporary.descriptor < 0 && errno == EINTR);
        if (temporary.descriptor >= 0) {
            // The replaced file's permissions stay; it does no harm where they cannot be set.
            if (target.exists) static_cast<void>(::fchmod(temporary.descriptor, target.mode));
            return temporary;
        }
        why = errno;
        if (why != EEXIST) break;
    }
    return file_error("E-FILE-007",
                      "no temporary file can be created in " + target.folder + ": " + reason_of(why), path,
                      advice_of(why));
}

}  // namespace

Status check_writable(const std::string& path, SystemCalls& calls) {
    ANATOMESH_TRY(const Target target, find_target(path));
    clean_up(target.folder, calls);
    ANATOMESH_TRY(const Temporary temporary, create_temporary(target, path, calls));
    close_checked(temporary.descriptor, calls);
    calls.unlink(temporary.name.c_str());
    return Nothing{};
}

Status write_file_atomically(const std::string& path, std::string_view content, SystemCalls& calls) {
    ANATOMESH_TRY(AtomicFile file, AtomicFile::create(path, calls));
    ANATOMESH_CHECK_STATUS(file.write(content));
    return file.commit();
}

Result<AtomicFile> AtomicFile::create(const std::string& path, SystemCalls& calls) {
    ANATOMESH_TRY(Target target, find_target(path));
    clean_up(target.folder, calls);
    ANATOMESH_TRY(Temporary temporary, create_temporary(target, path, calls));
    AtomicFile file(path, calls);
    file.target_ = std::move(target.file);
    file.folder_ = std::move(target.folder);
    file.temporary_ = std::move(temporary.name);
    file.descriptor_ = temporary.descriptor;
    return file;
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      folder_(std::move(other.folder_)),
      temporary_(std::exchange(other.temporary_, {})),
      calls_(other.calls_),
      size_(other.size_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      finished_(other.finished_),
      placed_(std::exchange(other.placed_, Placed::no)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
    if (this == &other) return *this;
    release();
    path_ = std::move(other.path_);
    target_ = std::move(other.target_);
    folder_ = std::move(other.folder_);
    temporary_ = std::exchange(other.temporary_, {});
    calls_ = other.calls_;
    size_ = other.size_;
    descriptor_ = std::exchange(other.descriptor_, -1);
    finished_ = other.finished_;
    placed_ = std::exchange(other.placed_, Placed::no);
    return *this;
}

AtomicFile::~AtomicFile() {
    release();
}

void AtomicFile::release() noexcept {
    if (descriptor_ >= 0) calls_->close(std::exchange(descriptor_, -1));
    // After a rename there is no temporary file any more; after an exchange it holds the old content.
    const bool there = placed_ == Placed::no || placed_ == Placed::exchanged;
    if (!temporary_.empty() && there) calls_->unlink(temporary_.c_str());
    temporary_.clear();
}

Status AtomicFile::write(std::string_view data) {
    assert(!finished_ && descriptor_ >= 0);
    if (const int why = write_checked(descriptor_, data, size_, *calls_); why != 0)
        return file_error("E-FILE-008",
                          "writing failed after " + std::to_string(size_) + " bytes: " + reason_of(why),
                          path_, advice_of(why));
    return Nothing{};
}

Status AtomicFile::finish() {
    assert(!finished_ && descriptor_ >= 0);
    const int synced = sync_checked(descriptor_, *calls_);
    const int closed = close_checked(std::exchange(descriptor_, -1), *calls_);
    if (const int why = synced != 0 ? synced : closed; why != 0) {
        return file_error(
            "E-FILE-009",
            "the " + std::to_string(size_) + " bytes could not be written to the disk: " + reason_of(why),
            path_, advice_of(why));
    }
    finished_ = true;
    return Nothing{};
}

Status AtomicFile::place() {
    assert(finished_ && placed_ == Placed::no);
    int why = 0;
    do {
        why = calls_->exchange(temporary_.c_str(), target_.c_str()) == 0 ? 0 : errno;
    } while (why == EINTR);
    if (why == 0) {
        placed_ = Placed::exchanged;
        return Nothing{};
    }
    // Nothing there to exchange with, or a file system that cannot: a plain rename.
    const Placed how = why == ENOENT ? Placed::created : Placed::replaced;
    do {
        why = calls_->rename(temporary_.c_str(), target_.c_str()) == 0 ? 0 : errno;
    } while (why == EINTR);
    if (why == 0) {
        placed_ = how;
        return Nothing{};
    }
    return file_error("E-FILE-010", "the finished file could not be renamed: " + reason_of(why), path_,
                      advice_of(why));
}

void AtomicFile::take_back() {
    switch (placed_) {
        case Placed::exchanged:
            // When the way back is barred the old content is moved back by a rename.
            if (calls_->exchange(temporary_.c_str(), target_.c_str()) == 0) {
                placed_ = Placed::no;
            } else if (calls_->rename(temporary_.c_str(), target_.c_str()) == 0) {
                placed_ = Placed::created;
            }
            break;
        case Placed::created:
            calls_->unlink(target_.c_str());
            break;
        case Placed::replaced:  // the old content is gone: the new one, which is complete, stays
        case Placed::no:
            break;
    }
}

Status AtomicFile::commit() {
    AtomicFileSet set(*calls_);
    ANATOMESH_CHECK_STATUS(set.add(std::move(*this)));
    return set.commit();
}

Status AtomicFileSet::add(const std::string& path, std::string_view content) {
    ANATOMESH_TRY(AtomicFile file, AtomicFile::create(path, *calls_));
    ANATOMESH_CHECK_STATUS(file.write(content));
    return add(std::move(file));
}

Status AtomicFileSet::add(AtomicFile file) {
    const std::string target = std::filesystem::path(file.target_).lexically_normal().string();
    for (const AtomicFile& other : files_) {
        if (std::filesystem::path(other.target_).lexically_normal().string() == target) {
            Error error =
                file_error("E-FILE-012", "two outputs have the same name", file.path_, "name another file");
            error.kind = ErrorKind::usage;
            return error;
        }
    }
    if (!file.finished_) {
        ANATOMESH_CHECK_STATUS(file.finish());
    }
    files_.push_back(std::move(file));
    return Nothing{};
}

Status AtomicFileSet::sync_once(const AtomicFile& file, std::vector<std::string>& synced,
                                SystemCalls& calls) {
    const std::string& folder = file.folder_;
    if (std::find(synced.begin(), synced.end(), folder) != synced.end()) return Nothing{};
    synced.push_back(folder);
    if (const int why = sync_folder(folder, calls); why != 0)
        return file_error("E-FILE-009", "folder " + folder + " could not be synced: " + reason_of(why),
                          file.path_, advice_of(why));
    return Nothing{};
}

Result<std::string> AtomicFileSet::begin_journal(const std::vector<AtomicFile>& files) {
    if (files.size() < 2) return std::string();
    std::vector<PendingOutput> pending;
    for (const AtomicFile& file : files) pending.push_back({file.temporary_, file.target_});
    // The journal is believed after a power failure, so the names that it tells of are on the disk before it: those in its own
    // folder go with its own name.
    std::vector<std::string> synced{files.front().folder_};
    for (const AtomicFile& file : files) {
        ANATOMESH_CHECK_STATUS(sync_once(file, synced, *calls_));
    }
    // Each temporary file's name is its run's alone.
    std::string journal = files.front().temporary_ + std::string(journal_suffix);
    if (const int why = write_journal(journal, pending, *calls_); why != 0) {
        return file_error("E-FILE-007",
                          "no list of the outputs can be written in their folder: " + reason_of(why),
                          files.front().path_, advice_of(why));
    }
    return journal;
}

Status AtomicFileSet::commit(const std::function<Status()>& last) {
    std::vector<AtomicFile> files = std::move(files_);
    files_.clear();
    ANATOMESH_TRY(const std::string journal, begin_journal(files));
    std::optional<Error> failure;
    std::size_t placed = 0;
    for (; placed < files.size(); ++placed) {
        Status status = files[placed].place();
        if (!status.ok()) {
            failure = std::move(status).error();
            break;
        }
    }
    std::vector<std::string> synced;
    for (std::size_t i = 0; i < files.size() && !failure; ++i) {
        Status status = sync_once(files[i], synced, *calls_);
        if (!status.ok()) failure = std::move(status).error();
    }
    if (!failure && last) {
        Status status = last();
        if (!status.ok()) failure = std::move(status).error();
    }
    if (failure) {
        while (placed > 0) files[--placed].take_back();
    }
    if (!journal.empty()) calls_->unlink(journal.c_str());
    if (failure) return *std::move(failure);
    return Nothing{};
}

}  // namespace anatomesh
