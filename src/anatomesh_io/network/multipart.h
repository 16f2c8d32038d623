// MultipartReader: the parts of a multipart/related message, as it comes in. Keeps no more of a part than
// what could be the beginning of a boundary. Follows: RFC 2046, 5.1.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace anatomesh {

// The boundary in a Content-Type of multipart/related; nothing when there is none.
std::optional<std::string> boundary_of(std::string_view content_type);

class MultipartReader {
  public:
    // Each returns whether to go on.
    struct Sink {
        std::function<bool()> begin;
        std::function<bool(std::string_view)> data;
        std::function<bool()> end;
    };
    MultipartReader(const std::string& boundary, Sink sink)
        : delimiter_("\r\n--" + boundary), sink_(std::move(sink)) {}

    // False: the message is malformed (headers of a part longer than 16 KiB), or the sink has stopped it.
    bool feed(std::string_view bytes);
    // Whether the last boundary has come.
    bool is_complete() const { return state_ == State::over; }

  private:
    enum class State : std::uint8_t { preamble, boundary, headers, content, over };
    bool step(bool& is_short);

    std::string delimiter_;
    Sink sink_;
    State state_ = State::preamble;
    std::string rest_ = "\r\n";  // the first boundary may have nothing before it
    std::size_t at_ = 0;         // of rest_, which is used up to there
};

}  // namespace anatomesh
