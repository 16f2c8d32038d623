// SetJournal: what a set of outputs is about to rename, so that a killed run can be finished by the next one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh_io/file/system_calls.h"

namespace anatomesh {

inline constexpr std::string_view journal_suffix = ".set";

// A finished temporary file and the name that it gets.
struct PendingOutput {
    std::string temporary, target;
};

// Writes the journal of outputs that are all complete on the disk: for each its two names, which file the temporary one
// is, and which file, if any, the target is now. It is synced, and so is its folder. Returns 0, or the errno of what failed; the
// journal is removed then. O(outputs)
int write_journal(const std::string& path, const std::vector<PendingOutput>& outputs, SystemCalls& calls);

// Finishes what a killed run began: an output that has not its name yet gets it, unless somebody changed the target since
// then, and what was replaced is removed. A journal that is not whole was written before the first rename, so that
// nothing is to be finished. The journal is removed. Only a regular file of this user is read, and only temporary files of this
// user whose names begin with `prefix` are touched: nobody else can have files renamed. Best effort.
void finish_journal(const std::string& path, std::string_view prefix, SystemCalls& calls);

}  // namespace anatomesh
