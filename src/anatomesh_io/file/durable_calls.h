// Durable calls: what is written is on the disk, and so is its name.
#pragma once

#include <string>

#include "anatomesh_io/file/system_calls.h"

namespace anatomesh {

// The folder of a path; "." where it names none.
std::string folder_of(const std::string& path);

// Each returns 0, or the errno. A call that a signal interrupts is made again; Linux has closed a descriptor even when close()
// says EINTR. File systems that cannot sync a folder say EINVAL: there is nothing more to do then, which is no failure.
int close_checked(int descriptor, SystemCalls& calls);
int sync_checked(int descriptor, SystemCalls& calls);
int sync_folder(const std::string& folder, SystemCalls& calls);

}  // namespace anatomesh
