// run_in_child: work on untrusted data in a process of its own, so that a decoder that crashes, hangs or eats
// memory is one error and no more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "anatomesh/base/run_context.h"

namespace anatomesh {

struct ChildLimits {
    std::uint64_t memory_bytes = std::uint64_t{2} << 30;  // beyond what this process has already
    unsigned seconds = 120;                               // of processor time, for one step
};

// What went wrong in which step.
struct ChildFailure {
    std::size_t step = 0;
    std::string reason;  // "the decoder was stopped by signal 11", "out of time", or what the step returned
};

// Calls step(0), step(1), ... step(count - 1) in a forked child. A step returns an empty text, or why it
// failed; it writes its results to memory that was shared before (SharedBytes). Gives progress and obeys
// cancellation. Returns the failure, or nothing. `cancelled` is set when the run was cancelled.
struct ChildResult {
    bool ok = true, cancelled = false;
    ChildFailure failure;
};
ChildResult run_in_child(std::size_t count, const std::function<std::string(std::size_t)>& step,
                         const ChildLimits& limits, const RunContext& context);

// Zeroed memory that a child and its parent share.
class SharedBytes {
  public:
    explicit SharedBytes(std::size_t size);  // data() is null when there is no memory
    SharedBytes(SharedBytes&& other) noexcept;
    SharedBytes& operator=(SharedBytes&& other) noexcept;
    SharedBytes(const SharedBytes&) = delete;
    SharedBytes& operator=(const SharedBytes&) = delete;
    ~SharedBytes();
    std::byte* data() const { return data_; }
    std::size_t size() const { return size_; }

  private:
    std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace anatomesh
