// Durable calls: what is written is on the disk, and so is its name.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "anatomesh_io/file/system_calls.h"

namespace anatomesh {

// The folder of a path; "." where it names none.
std::string folder_of(const std::string& path);

// What an errno of writing means, and what the user can do about it; for messages.
std::string reason_of(int error_number);
std::string advice_of(int error_number);

// Writes all of `bytes` and adds to `written` what was written, also where a later piece fails. Returns 0, or the errno.
// Interrupted and short writes go on. A file that would pass RLIMIT_FSIZE gives EFBIG, and SIGXFSZ ends no process.
int write_checked(int descriptor, std::string_view bytes, std::uint64_t& written, SystemCalls& calls);

// Each returns 0, or the errno. A call that a signal interrupts is made again; Linux has closed a descriptor even when close()
// says EINTR. File systems that cannot sync a folder say EINVAL: there is nothing more to do then, which is no failure.
int close_checked(int descriptor, SystemCalls& calls);
int sync_checked(int descriptor, SystemCalls& calls);
int sync_folder(const std::string& folder, SystemCalls& calls);

}  // namespace anatomesh
