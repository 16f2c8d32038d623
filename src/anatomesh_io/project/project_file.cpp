#include "anatomesh_io/project/project_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/file/durable_calls.h"
#include "anatomesh_io/file/uninterrupted.h"
#include "anatomesh_io/project/record_line.h"
#include "anatomesh_io/project/write_record.h"

namespace anatomesh {

namespace {

Error exists_already(const std::string& path) {
    return {ErrorKind::file,
            "E-PRJ-010",
            "there is a file of this name already",
            {path, "", "", "", ""},
            "choose another name, or open it"};
}

// Gives a draft its name, unless another file has it: of two processes that create one project the second fails. Returns
// 0 or an error number.
int publish(const std::string& draft, const std::string& path) {
    if (uninterrupted([&] { return ::link(draft.c_str(), path.c_str()); }) == 0) {
        ::unlink(draft.c_str());
        return 0;
    }
    const int why = errno;
    // Some file systems have no links; there the name was free a moment ago.
    const bool has_no_links = why == EPERM || why == ENOTSUP || why == ENOSYS;
    if (has_no_links && uninterrupted([&] { return ::rename(draft.c_str(), path.c_str()); }) == 0) return 0;
    ::unlink(draft.c_str());
    return why;
}

}  // namespace

Result<ProjectFile> ProjectFile::create(const std::string& path, const DrawingSource& source,
                                        SystemCalls& calls) {
    struct stat state {};
    if (uninterrupted([&] { return ::lstat(path.c_str(), &state); }) == 0) return exists_already(path);
    RunContext context;
    const std::string line = record_line(head_record(source));
    // A head that no reader takes leaves no file behind.
    ANATOMESH_CHECK_STATUS(replay_project(line, path, {{}, false}, context));
    const std::string draft = path + ".new-" + std::to_string(::getpid());
    if (Status written = write_file_atomically(draft, line, calls); !written.ok()) {
        Error error = written.error();
        error.place.file = path;
        return error;
    }
    const int why = publish(draft, path);
    if (why == EEXIST) return exists_already(path);
    if (why != 0)
        return Error{ErrorKind::file,
                     "E-PRJ-006",
                     "the project cannot be given its name: " + reason_of(why),
                     {path, "", "", "", ""},
                     advice_of(why)};
    if (const int unsynced = sync_folder(folder_of(path), calls); unsynced != 0)
        return Error{ErrorKind::file,
                     "E-PRJ-006",
                     "the folder of the project cannot be synced: " + reason_of(unsynced),
                     {path, "", "", "", ""},
                     advice_of(unsynced)};
    return open(path, {}, context, calls);
}

Result<ProjectFile> ProjectFile::open(const std::string& path, const ProjectLimits& limits,
                                      RunContext& context, SystemCalls& calls) {
    ProjectFile file(path, calls);
    ANATOMESH_CHECK_STATUS(file.open_and_lock());
    ANATOMESH_TRY(const InputFile content, read_input_file(path, limits.file));
    const std::string_view text = as_text(content.bytes());
    ANATOMESH_TRY(file.project_, replay_project(text, path, {limits, false}, context));
    // What was read by its name has to be what is locked.
    if (!file.is_at_its_path()) return file.replaced_error();
    int why = 0;
    if (file.project_.is_cut)
        why = uninterrupted([&] {
                  return calls.truncate(file.descriptor_, static_cast<off_t>(file.project_.whole_bytes));
              }) == 0
                  ? 0
                  : errno;
    // What was read counts as kept from now on, so it has to be on the disk.
    if (why == 0) why = sync_checked(file.descriptor_, calls);
    if (why != 0) return file.write_error("E-PRJ-006", "the project cannot be opened for writing", why);
    return file;
}

Status ProjectFile::open_and_lock() {
    descriptor_ = uninterrupted([&] {
        return calls_->open(path_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0);
    });
    if (descriptor_ < 0) {
        const int why = errno;
        // A file that cannot be read either is no matter of writing.
        ANATOMESH_CHECK_STATUS(read_input_start(path_, 1));
        return write_error("E-PRJ-006", "the project cannot be opened for writing", why);
    }
    if (uninterrupted([&] { return ::flock(descriptor_, LOCK_EX | LOCK_NB); }) == 0) return Nothing{};
    if (errno == EWOULDBLOCK)
        return Error{ErrorKind::file,
                     "E-PRJ-005",
                     "another process has the project open",
                     {path_, "", "", "", ""},
                     "close it there, or work on a copy"};
    return write_error("E-PRJ-006", "the project cannot be locked", errno);
}

ProjectFile::ProjectFile(ProjectFile&& other) noexcept
    : path_(std::move(other.path_)),
      calls_(other.calls_),
      project_(std::move(other.project_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      has_failed_(other.has_failed_) {}

ProjectFile& ProjectFile::operator=(ProjectFile&& other) noexcept {
    if (this == &other) return *this;
    close();
    path_ = std::move(other.path_);
    calls_ = other.calls_;
    project_ = std::move(other.project_);
    descriptor_ = std::exchange(other.descriptor_, -1);
    has_failed_ = other.has_failed_;
    return *this;
}

ProjectFile::~ProjectFile() {
    close();
}

void ProjectFile::close() noexcept {
    if (descriptor_ >= 0) close_checked(std::exchange(descriptor_, -1), *calls_);
}

Status ProjectFile::apply(Edit edit) {
    const std::string record = apply_record(records(), edit);
    return project_.history.apply(std::move(edit), [&] { return append(record); });
}

Result<bool> ProjectFile::undo() {
    return project_.history.undo(
        [&] { return append(move_record(records(), "undo", history().done().back().name)); });
}

Result<bool> ProjectFile::redo() {
    return project_.history.redo(
        [&] { return append(move_record(records(), "redo", history().undone().back().name)); });
}

bool ProjectFile::is_at_its_path() const {
    struct stat held {
    }, named{};
    return uninterrupted([&] { return ::fstat(descriptor_, &held); }) == 0 &&
           uninterrupted([&] { return ::stat(path_.c_str(), &named); }) == 0 && held.st_dev == named.st_dev &&
           held.st_ino == named.st_ino;
}

Error ProjectFile::replaced_error() const {
    return {ErrorKind::file,
            "E-PRJ-009",
            "another program removed or replaced the file of the project",
            {path_, "", "", "", ""},
            "close that program, and open the project again; the last step is not kept"};
}

// A lock is advisory: a program that knows nothing of it may have removed, replaced or lengthened the file.
Status ProjectFile::check_untouched() const {
    struct stat state {};
    if (uninterrupted([&] { return ::fstat(descriptor_, &state); }) != 0)
        return write_error("E-PRJ-007", "the step cannot be written", errno);
    if (state.st_nlink == 0 || !is_at_its_path()) return replaced_error();
    if (static_cast<std::uint64_t>(state.st_size) == bytes()) return Nothing{};
    return Error{ErrorKind::file,
                 "E-PRJ-009",
                 "another program changed the file of the project",
                 {path_, "", "", "", ""},
                 "close that program, and open the project again; the last step is not kept"};
}

Status ProjectFile::append(std::string_view record) {
    if (has_failed_)
        return Error{ErrorKind::file,
                     "E-PRJ-008",
                     "an earlier write failed, and what the file holds is not known",
                     {path_, "", "", "", ""},
                     "open the project again"};
    if (record.size() > most_record_bytes)
        return Error{ErrorKind::limit,
                     "E-PRJ-011",
                     "the step is larger than a record may be",
                     {path_, "", "", "", std::to_string(record.size()) + " bytes"},
                     "make the change in several steps"};
    ANATOMESH_CHECK_STATUS(check_untouched());
    const std::string line = record_line(record);
    std::uint64_t written = 0;
    int why = write_checked(descriptor_, line, written, *calls_);
    if (why == 0) {
        why = sync_checked(descriptor_, *calls_);
        // After a failed sync nobody knows which bytes are on the disk; a second one would say that all is well.
        has_failed_ = why != 0;
    }
    if (why == 0) {
        ++project_.records;
        project_.whole_bytes += line.size();
        return Nothing{};
    }
    const int cut = uninterrupted([&] { return calls_->truncate(descriptor_, static_cast<off_t>(bytes())); });
    has_failed_ |= cut != 0 || sync_checked(descriptor_, *calls_) != 0;
    return write_error("E-PRJ-007",
                       has_failed_
                           ? "the step could not be written, and whether the file holds it is not known"
                           : "the step could not be written, and is not kept",
                       why);
}

Error ProjectFile::write_error(const char* code, const std::string& what, int why) const {
    return {ErrorKind::file, code, what + ": " + reason_of(why), {path_, "", "", "", ""}, advice_of(why)};
}

}  // namespace anatomesh
