// read_project: what a project file holds: the drawing, and the steps that can be undone and redone.
//
// Errors (kind input unless stated) name the path, and the record by its number and byte:
//   E-PRJ-001 no project file          E-PRJ-004 a record that cannot be, or that does not fit to those before it
//   E-PRJ-002 of a newer version       E-PRJ-011 (limit) the edits hold too many points
//   E-PRJ-003 a damaged record         and those of input_file.h
//   W-PRJ-001 the last record was not written to its end; it is left out
//   W-PRJ-002 what follows a damaged record is left out, because the caller asked for what can be read
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "anatomesh/base/run_context.h"
#include "anatomesh/live/edit/edit_history.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

struct ProjectLimits {
    InputLimits file;
    std::uint64_t points = 200'000'000;  // of all edits together, also those that were undone. [1, 2^32)
};

struct ReadProjectOptions {
    ProjectLimits limits;
    // Whether a damaged record is the end of the file instead of an error. Default: false.
    bool readable_part = false;
};

struct Project {
    EditHistory history;
    std::uint64_t records = 0;      // that were read, the head included
    std::uint64_t whole_bytes = 0;  // of the file: the records that were read
    bool is_cut = false;  // the file goes on behind them: the last record is torn, or one is damaged
};

// Replays the records of a file; it takes no lock and changes nothing. Guarantees: the same drawing and the same steps as
// when the last record was written, bit for bit. Complexity: linear in the file and in the points of its edits.
Result<Project> read_project(const std::string& path, const ReadProjectOptions& options, RunContext& context);

// The same of the bytes of a file; `path` is for messages.
Result<Project> replay_project(std::string_view text, const std::string& path,
                               const ReadProjectOptions& options, RunContext& context);

// Writes the records that can be read into a project file of its own, whole or not at all. Returns them as read from
// `path`. Errors: those of read_project() but E-PRJ-003 and E-PRJ-004 of later records; those of atomic_file.h.
Result<Project> save_readable_part(const std::string& path, const std::string& output,
                                   const ProjectLimits& limits, RunContext& context);

}  // namespace anatomesh
