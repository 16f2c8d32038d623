// RunContext: a stage gets this besides its input: threads, cancellation, progress, and a place for warnings.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"

namespace anatomesh {

// A run has one, and hands it by reference to every stage. Only cancelled() is thread-safe. Stages warn and report
// progress from the thread that called them, so warnings come in the same order for any number of threads.
class RunContext {
  public:
    // It is called with the stage's name and the share done, 0 to 1, and never from two threads at once.
    using Progress = std::function<void(const std::string& stage, double share)>;

    int threads = 1;                            // at least 1
    const std::atomic<bool>* cancel = nullptr;  // set to true by the caller to stop the run
    Progress progress;                          // may be empty
    std::vector<Warning> warnings;              // blemishes found so far, in input order

    bool cancelled() const { return cancel && cancel->load(std::memory_order_relaxed); }
    void warn(Warning warning) { warnings.push_back(std::move(warning)); }
    void report(const std::string& stage, double share) const {
        if (progress) progress(stage, share);
    }
};

inline Error cancelled_error() {
    return {ErrorKind::cancelled, "E-RUN-001", "cancelled", {}, ""};
}

}  // namespace anatomesh
