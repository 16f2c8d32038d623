// AtomicFile: an output that appears whole or not at all.
//
// The content goes to a temporary file in the same folder, every write and the close are checked, the file is
// synced, renamed to its name, and the folder is synced. Until the rename the old file is untouched. A
// process that is killed leaves the old or the complete new file, and perhaps a temporary file named
// ".anatomesh-<machine>-<pid>-<n>.tmp", which the next run that writes into the folder removes; of several outputs
// it finishes what was begun.
//
// Errors are of kind `file` (exit code 6; E-FILE-012 of kind `usage`) and name the path:
//   E-FILE-001 no such folder             E-FILE-007 the temporary file cannot be created
//   E-FILE-002 folder cannot be written   E-FILE-008 a write failed (says at which byte)
//   E-FILE-003 file cannot be written     E-FILE-009 sync or close failed
//   E-FILE-004 the path is a folder       E-FILE-010 rename failed
//   E-FILE-005 path too long              E-FILE-011 empty path
//   E-FILE-006 not a regular file         E-FILE-012 two outputs of one run have the same path
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh_io/file/system_calls.h"

namespace anatomesh {

// Whether an output could be written at `path`: call it before a long computation. Follows a symbolic link.
// Removes temporary files that killed runs on this machine left in the folder. Creates and removes one there.
Status check_writable(const std::string& path, SystemCalls& calls = SystemCalls::real());

// Writes a whole file. All or nothing.
Status write_file_atomically(const std::string& path, std::string_view content,
                             SystemCalls& calls = SystemCalls::real());

// One output. Order of use: create, write ..., finish, then publish by AtomicFileSet or commit().
// Not thread-safe. The destructor removes what was not committed.
class AtomicFile {
  public:
    // Checks the path as check_writable does and creates the temporary file. `calls` must outlive the file.
    static Result<AtomicFile> create(const std::string& path, SystemCalls& calls = SystemCalls::real());

    AtomicFile(AtomicFile&& other) noexcept;
    AtomicFile& operator=(AtomicFile&& other) noexcept;
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;
    ~AtomicFile();

    // Appends. Interrupted and short writes go on. Requires: not finished.
    Status write(std::string_view data);
    // Syncs and closes the temporary file: all of the content is on the disk. Requires: not finished.
    Status finish();
    // Finishes when that was not done, gives the file its name, syncs the folder.
    Status commit();

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }

  private:
    friend class AtomicFileSet;
    enum class Placed : std::uint8_t { no, created, replaced, exchanged };

    AtomicFile(std::string path, SystemCalls& calls) : path_(std::move(path)), calls_(&calls) {}
    Status place();           // the rename
    void take_back();         // undoes place()
    void release() noexcept;  // closes, removes the temporary file (or the old content)

    std::string path_;       // as the caller named it
    std::string target_;     // path_ with a symbolic link followed
    std::string folder_;     // of target_
    std::string temporary_;  // empty when there is none
    SystemCalls* calls_;
    std::uint64_t size_ = 0;
    int descriptor_ = -1;
    bool finished_ = false;
    Placed placed_ = Placed::no;
};

// Several outputs of one run that appear together: all are complete on the disk before the first is renamed,
// and when a rename fails the earlier ones are undone (as far as the file system lets; old contents are kept
// aside by exchanging names until the end). A run that ends between two renames, by a kill or a power failure, leaves
// a journal: the next run that writes into the folder of the first output gives the others their names, so that all
// appear (set_journal.h).
class AtomicFileSet {
  public:
    explicit AtomicFileSet(SystemCalls& calls = SystemCalls::real()) : calls_(&calls) {}

    // Writes one output under its temporary name and syncs it.
    Status add(const std::string& path, std::string_view content);
    // Takes a file that the caller has written; finishes it when that was not done.
    Status add(AtomicFile file);
    // Gives all outputs their names. The set is empty afterwards; nothing has changed on failure. `last`,
    // when given, is called once all have their names; when it fails, they are taken back.
    Status commit(const std::function<Status()>& last = {});

    std::size_t size() const { return files_.size(); }

  private:
    // The journal of several files that are about to get their names (set_journal.h); an empty text for one.
    Result<std::string> begin_journal(const std::vector<AtomicFile>& files);
    // Syncs the folder of a file, unless it is among `synced`, and adds it there. Error: E-FILE-009.
    static Status sync_once(const AtomicFile& file, std::vector<std::string>& synced, SystemCalls& calls);

    SystemCalls* calls_;
    std::vector<AtomicFile> files_;
};

}  // namespace anatomesh
