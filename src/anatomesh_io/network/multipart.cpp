#include "anatomesh_io/network/multipart.h"

#include <algorithm>

#include "anatomesh/base/text.h"

namespace anatomesh {

namespace {

// The headers of a part are no longer, so that a hostile server takes no memory. [bytes; >= 1024; B]
constexpr std::size_t longest_headers = 16384;
// A boundary has no more characters. [bytes; 70; D RFC 2046, section 5.1.1]
constexpr std::size_t longest_boundary = 70;

}  // namespace

std::optional<std::string> boundary_of(std::string_view content_type) {
    const std::string lower = lower_case(content_type);
    if (!lower.starts_with("multipart/related")) return std::nullopt;
    constexpr std::string_view name = "boundary=";
    const std::size_t found = lower.find(name);
    if (found == std::string::npos) return std::nullopt;
    std::string_view value = content_type.substr(found + name.size());
    if (value.starts_with('"')) {
        value.remove_prefix(1);
        value = value.substr(0, value.find('"'));
    } else {
        value = value.substr(0, value.find_first_of("; \t"));
    }
    if (value.empty() || value.size() > longest_boundary) return std::nullopt;
    return std::string(value);
}

bool MultipartReader::feed(std::string_view bytes) {
    rest_ += bytes;
    bool is_short = false;
    while (!is_short && state_ != State::over)
        if (!step(is_short)) return false;
    rest_.erase(0, state_ == State::over ? rest_.size() : at_);
    at_ = 0;
    return true;
}

// Takes what can be taken of rest_; `is_short`: nothing more before more has come.
bool MultipartReader::step(bool& is_short) {
    const std::string_view rest = std::string_view(rest_).substr(at_);
    switch (state_) {
        case State::preamble:
        case State::content: {
            const std::size_t found = rest.find(delimiter_);
            const bool is_found = found != std::string_view::npos;
            // What may be the beginning of a delimiter waits.
            const std::size_t sure =
                is_found ? found : rest.size() - std::min(rest.size(), delimiter_.size() - 1);
            if (state_ == State::content && sure > 0 && !sink_.data(rest.substr(0, sure))) return false;
            at_ += sure;
            is_short = !is_found;
            if (!is_found) return true;
            at_ += delimiter_.size();
            if (state_ == State::content && !sink_.end()) return false;
            state_ = State::boundary;
            return true;
        }
        case State::boundary: {
            if (rest.starts_with("--")) {
                state_ = State::over;
                return true;
            }
            const std::size_t end = rest.find("\r\n");
            is_short = end == std::string_view::npos;
            if (is_short) return rest.size() < longest_headers;
            // The line's end stays: headers end with an empty line, also when there are none.
            at_ += end;
            state_ = State::headers;
            return true;
        }
        case State::headers: {
            const std::size_t end = rest.find("\r\n\r\n");
            is_short = end == std::string_view::npos;
            if (is_short) return rest.size() < longest_headers;
            at_ += end + 4;
            state_ = State::content;
            return sink_.begin();
        }
        case State::over:
            break;
    }
    return true;
}

}  // namespace anatomesh
