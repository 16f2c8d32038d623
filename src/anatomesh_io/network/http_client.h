// HttpClient: requests to a DICOMweb service over HTTP or HTTPS.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/network/peer.h"

namespace anatomesh {

struct HttpReply {
    int status = 0;
    std::string content_type;
};

// One at a time; not thread-safe. Redirections are not followed. A request ends within `options.limits`, and
// within 0.1 s when the run is cancelled (but for the look-up of a host name); it takes no memory beyond
// 16 MiB of framing. Errors: E-NET-016 no answer (no connection, TLS, silence), E-NET-018 the answer is endless
// headers or longer than 64 MiB, E-NET-004 TLS files; those of RequestBudget; cancelled.
class HttpClient {
  public:
    // Requires: options.peer.url. `context` must outlive it.
    HttpClient(const ConnectOptions& options, const RunContext& context);
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;
    ~HttpClient();

    // Called with the status and the type of the content before it, and with its pieces; each returns whether
    // to go on.
    struct Receiver {
        std::function<bool(const HttpReply&)> begin;
        std::function<bool(std::string_view)> data;
    };
    // `path` follows the base URL and begins with a slash.
    Result<HttpReply> get(const std::string& path, const std::string& accept, const Receiver& receiver);
    // Sends `size` bytes, piece by piece as `read(offset, most)` gives them; the content of the answer, at most
    // 64 MiB, goes to `answer`.
    using Read = std::function<std::string_view(std::uint64_t offset, std::size_t most)>;
    Result<HttpReply> post(const std::string& path, const std::string& content_type,
                           const std::string& accept, std::uint64_t size, const Read& read,
                           std::string& answer);

    // The error for a status that is no success: E-NET-017.
    Error refused(const HttpReply& reply, const std::string& what) const;

  private:
    struct Door;
    std::unique_ptr<Door> door_;
};

// `text` as a part of a URL.
std::string url_escaped(std::string_view text);

}  // namespace anatomesh
