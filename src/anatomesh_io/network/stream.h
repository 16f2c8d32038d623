// Streams: TCP connections, plain or under TLS, that never wait: waiting is the caller's, by poll().
//
// TLS is 1.2 or newer with forward secrecy and authenticated encryption, after BCP 195.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"

struct ssl_st;
struct ssl_ctx_st;

namespace anatomesh {

using Clock = std::chrono::steady_clock;

// PEM files. A server needs certificate and key; with `authorities` it asks clients for certificates of them.
// A client checks the server against `authorities` (empty: those of the system).
struct TlsFiles {
    std::string certificate, key, authorities;
    bool empty() const { return certificate.empty() && key.empty() && authorities.empty(); }
};

class TlsContext {
  public:
    // Error (file): E-NET-004 a file cannot be used.
    static Result<TlsContext> server(const TlsFiles& files);
    static Result<TlsContext> client(const TlsFiles& files);
    ssl_ctx_st* get() const { return context_.get(); }

  private:
    std::shared_ptr<ssl_ctx_st> context_;
};

enum class StreamState : std::uint8_t { done, wants_read, wants_write, closed, failed };

// Owns its socket.
class Stream {
  public:
    explicit Stream(int descriptor);
    // Over TLS; the handshake goes on within read and write. `host` is the name that a client checks.
    Stream(int descriptor, const TlsContext& tls, bool is_server, const std::string& host);
    Stream(Stream&& other) noexcept;
    Stream& operator=(Stream&&) = delete;
    ~Stream();

    // Some bytes, at most `size`. `got` is set when done.
    StreamState read(char* into, std::size_t size, std::size_t& got);
    StreamState write(std::string_view bytes, std::size_t& put);
    // No more will be written.
    void shut_down();

    int descriptor() const { return descriptor_; }
    // Why the last call failed.
    const std::string& reason() const { return reason_; }

  private:
    StreamState tls_state(int result);

    int descriptor_;
    ssl_st* tls_ = nullptr;
    std::string reason_;
};

// A listening socket.
struct Listener {
    int descriptor = -1;
    std::uint16_t port = 0;  // the one that was given, or that the system chose
};
// Binds to an address of this machine. Error (file): E-NET-003 it cannot be bound.
Result<Listener> listen_at(const std::string& address, std::uint16_t port);

// The next connection of a listener, not blocking, its small packets sent at once; -1 when there is none.
// `peer` is its numeric address.
int accept_from(int listener, std::string& peer);

// Connects within the deadline. Error (file): E-NET-010 no connection.
Result<int> connect_to(const std::string& host, std::uint16_t port, Clock::time_point deadline,
                       const RunContext& context);

// The numeric addresses of a host name or address; none when it is not known.
std::vector<std::string> addresses_of(const std::string& host);
bool is_loopback(const std::string& address);

}  // namespace anatomesh
