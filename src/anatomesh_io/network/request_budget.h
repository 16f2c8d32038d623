// RequestBudget: what one request to a peer may take in all, so that no peer holds the program for ever or
// fills its memory, however steadily it sends. A timeout bounds the silence alone.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "anatomesh/base/result.h"

namespace anatomesh {

// A request takes no longer in all: a large study comes within the hour in a slow hospital network.
// [s; > 0; B]
inline constexpr double most_request_seconds = 3600;
// The answer to a request has no more bytes: no study of radiology is as large. [bytes; >= 65536; B]
inline constexpr std::uint64_t most_request_bytes = std::uint64_t{64} << 30;
// A request has no more answers, reports of progress and objects: beyond it a list helps nobody, and a peer
// that goes on means no good. [answers; >= 1; B]
inline constexpr std::uint64_t most_request_answers = 1'000'000;

struct RequestLimits {
    double seconds = most_request_seconds;
    std::uint64_t bytes = most_request_bytes;
    std::uint64_t answers = most_request_answers;
    // When the request began that this one is a part of. Nothing: it is none, and begins now.
    std::optional<std::chrono::steady_clock::time_point> begun;
};

// The clock begins with it, or at `limits.begun`. check_time() is thread-safe. Errors (limit), with the peer's name as their place:
// E-NET-025 the time, E-NET-026 the bytes, E-NET-027 the answers.
class RequestBudget {
  public:
    RequestBudget(const RequestLimits& limits, std::string peer);

    Status check_time() const;
    Status spend_bytes(std::uint64_t count);
    Status spend_answer();

  private:
    RequestLimits limits_;
    std::string peer_;
    std::chrono::steady_clock::time_point begun_;
    std::uint64_t bytes_ = 0, answers_ = 0;  // at most the limits
};

}  // namespace anatomesh
