// What the operating system can do to the process while it works.
#pragma once

#include <atomic>

namespace anatomesh {

struct ProcessState {
    const std::atomic<bool>* cancel = nullptr;
    bool output_closed = false;  // standard output was closed
};

// Opens /dev/null for standard streams that are closed, so that no output file can take their place; ignores
// SIGPIPE and SIGXFSZ, so that such a write fails by itself; makes SIGINT, SIGTERM and SIGHUP set the flag
// that is returned. A second signal ends the process at once with 130. Call once, first.
ProcessState prepare_process();

// Processors this process may run on (its affinity mask), at least 1.
int available_processors();

}  // namespace anatomesh
