// ProjectFile: a drawing whose every step is on the disk before it is acknowledged.
//
// The file is a log to which each step, undo and redo is appended, synced, and then taken into the history (write-ahead
// logging: Mohan et al., ARIES, ACM TODS 17, 1992). A process that is killed, or a power failure, leaves every acknowledged
// step and perhaps the begin of one more, which is cut off when the file is opened.
//
// Errors of kind `file` unless stated, besides those of read_project.h:
//   E-PRJ-005 another process has the project open    E-PRJ-008 an earlier write failed; open the project again
//   E-PRJ-006 it cannot be opened for writing         E-PRJ-009 another program removed or changed the file meanwhile
//   E-PRJ-007 a step could not be written             E-PRJ-010 there is a file of this name already
//   E-PRJ-011 (limit) a step is larger than a record may be
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "anatomesh/base/run_context.h"
#include "anatomesh/live/edit/edit_history.h"
#include "anatomesh_io/file/system_calls.h"
#include "anatomesh_io/project/read_project.h"

namespace anatomesh {

// One process has a project open for writing at a time, by an advisory lock (flock) until the object goes.
// Not thread-safe; drawings that it gave may be used on any thread. `calls` must outlive it.
class ProjectFile {
  public:
    // Makes a project file with nothing drawn, and opens it. Errors: E-PRJ-010; those of atomic_file.h and open().
    static Result<ProjectFile> create(const std::string& path, const DrawingSource& source,
                                      SystemCalls& calls = SystemCalls::real());

    // Opens a project file to go on with it. A torn last record is cut off, with the warning W-PRJ-001. Errors: those of
    // read_project(), E-PRJ-005, E-PRJ-006. Complexity: that of read_project().
    static Result<ProjectFile> open(const std::string& path, const ProjectLimits& limits, RunContext& context,
                                    SystemCalls& calls = SystemCalls::real());

    ProjectFile(ProjectFile&& other) noexcept;
    ProjectFile& operator=(ProjectFile&& other) noexcept;
    ProjectFile(const ProjectFile&) = delete;
    ProjectFile& operator=(const ProjectFile&) = delete;
    ~ProjectFile();

    const std::string& path() const { return path_; }
    const EditHistory& history() const { return project_.history; }
    const Drawing& drawing() const { return project_.history.drawing(); }
    std::uint64_t records() const { return project_.records; }  // the head included
    std::uint64_t bytes() const { return project_.whole_bytes; }

    // Each writes, syncs, and then moves the history. Where it returns an error nothing has changed. undo() and redo()
    // return false where there is no step. Errors: those of applied(); E-PRJ-007 to -009, -011. Complexity: that of
    // EditHistory, and one sync.
    Status apply(Edit edit);
    Result<bool> undo();
    Result<bool> redo();

  private:
    ProjectFile(std::string path, SystemCalls& calls) : path_(std::move(path)), calls_(&calls) {}
    Status open_and_lock();
    bool is_at_its_path() const;
    Error replaced_error() const;
    Status check_untouched() const;
    Status append(std::string_view record);
    Error write_error(const char* code, const std::string& what, int why) const;
    void close() noexcept;

    std::string path_;
    SystemCalls* calls_;
    Project project_;
    int descriptor_ = -1;
    bool has_failed_ = false;  // what is behind whole_bytes is not known
};

}  // namespace anatomesh
