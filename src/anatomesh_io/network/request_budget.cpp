#include "anatomesh_io/network/request_budget.h"

#include <fmt/format.h>

#include <utility>

namespace anatomesh {

namespace {

Error beyond_limit(const char* code, const std::string& message, const std::string& peer, const char* name) {
    return {ErrorKind::limit,
            code,
            message,
            {"", "", "", "", peer},
            fmt::format("look into the log of the other side; --limit {}=N allows more", name)};
}

}  // namespace

RequestBudget::RequestBudget(const RequestLimits& limits, std::string peer)
    : limits_(limits),
      peer_(std::move(peer)),
      begun_(limits.begun.value_or(std::chrono::steady_clock::now())) {}

Status RequestBudget::check_time() const {
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - begun_;
    if (gone.count() < limits_.seconds) return Nothing{};
    return beyond_limit(
        "E-NET-025",
        fmt::format("the other side did not come to an end within {:g} s in all", limits_.seconds), peer_,
        "request-seconds");
}

Status RequestBudget::spend_bytes(std::uint64_t count) {
    const bool fits = count <= limits_.bytes - bytes_;
    bytes_ = fits ? bytes_ + count : limits_.bytes;
    if (fits) return Nothing{};
    return beyond_limit("E-NET-026", fmt::format("the other side sends more than {} bytes", limits_.bytes),
                        peer_, "request-bytes");
}

Status RequestBudget::spend_answer() {
    if (answers_ < limits_.answers) {
        ++answers_;
        return Nothing{};
    }
    return beyond_limit(
        "E-NET-027", fmt::format("the other side gives more than {} answers to one request", limits_.answers),
        peer_, "request-answers");
}

}  // namespace anatomesh
