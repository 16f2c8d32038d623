#include "anatomesh_io/network/stream.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace anatomesh {

namespace {

constexpr const char* ciphers = "ECDHE+AESGCM:ECDHE+CHACHA20:DHE+AESGCM";

Error network_error(const char* code, std::string message, const std::string& value, std::string next_step) {
    return {ErrorKind::file, code, std::move(message), {"", "", "", "", value}, std::move(next_step)};
}

std::string tls_reason() {
    const unsigned long code = ERR_get_error();
    ERR_clear_error();
    const char* text = code ? ERR_reason_error_string(code) : nullptr;
    return text ? text : "the connection was lost";
}

std::string numeric_address(const sockaddr* address, socklen_t length) {
    char text[NI_MAXHOST] = "";
    if (::getnameinfo(address, length, text, sizeof text, nullptr, 0, NI_NUMERICHOST) != 0) return {};
    constexpr std::string_view mapped = "::ffff:";
    const std::string_view view(text);
    return std::string(view.starts_with(mapped) ? view.substr(mapped.size()) : view);
}

void make_prompt(int descriptor) {
    const int yes = 1;
    ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    ::setsockopt(descriptor, SOL_SOCKET, SO_KEEPALIVE, &yes, sizeof yes);
}

// Addresses of a host, freed with it.
class AddressList {
  public:
    AddressList(const std::string& host, std::uint16_t port, int flags) {
        addrinfo hints{};
        hints.ai_family = AF_UNSPEC;
        hints.ai_socktype = SOCK_STREAM;
        hints.ai_flags = flags | AI_NUMERICSERV;
        failure_ = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &first_);
    }
    AddressList(const AddressList&) = delete;
    AddressList& operator=(const AddressList&) = delete;
    ~AddressList() {
        if (first_) ::freeaddrinfo(first_);
    }
    const addrinfo* first() const { return first_; }
    std::string failure() const { return failure_ != 0 ? ::gai_strerror(failure_) : "no address"; }

  private:
    addrinfo* first_ = nullptr;
    int failure_ = 0;
};

// Waits until a connection that has begun is there; the errno of its failure, or 0.
int wait_for_connection(int descriptor, Clock::time_point deadline, const RunContext& context) {
    while (!context.cancelled()) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0) return ETIMEDOUT;
        pollfd state{descriptor, POLLOUT, 0};
        if (::poll(&state, 1, static_cast<int>(std::min<long long>(left.count(), 200))) <= 0) continue;
        int failure = 0;
        socklen_t size = sizeof failure;
        return ::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &failure, &size) == 0 ? failure : errno;
    }
    return ECANCELED;
}

Result<std::shared_ptr<ssl_ctx_st>> make_context(const TlsFiles& files, bool is_server) {
    std::shared_ptr<ssl_ctx_st> context(SSL_CTX_new(is_server ? TLS_server_method() : TLS_client_method()),
                                        SSL_CTX_free);
    const auto refuse = [&](const std::string& what, const std::string& file) {
        return Error{ErrorKind::file,
                     "E-NET-004",
                     what + ": " + tls_reason(),
                     {file, "", "", "", ""},
                     "give PEM files: --tls-certificate, --tls-key, --tls-authorities"};
    };
    if (!context) return refuse("TLS cannot be used", "");
    SSL_CTX* raw = context.get();
    SSL_CTX_set_min_proto_version(raw, TLS1_2_VERSION);
    SSL_CTX_set_cipher_list(raw, ciphers);
    SSL_CTX_set_mode(raw, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    if (!files.certificate.empty() && SSL_CTX_use_certificate_chain_file(raw, files.certificate.c_str()) != 1)
        return refuse("the certificate cannot be used", files.certificate);
    if (!files.key.empty() && (SSL_CTX_use_PrivateKey_file(raw, files.key.c_str(), SSL_FILETYPE_PEM) != 1 ||
                               SSL_CTX_check_private_key(raw) != 1))
        return refuse("the key cannot be used", files.key);
    if (files.authorities.empty()) {
        if (!is_server) SSL_CTX_set_default_verify_paths(raw);
    } else if (SSL_CTX_load_verify_locations(raw, files.authorities.c_str(), nullptr) != 1) {
        return refuse("the authorities cannot be used", files.authorities);
    }
    const bool asks = !is_server || !files.authorities.empty();
    SSL_CTX_set_verify(raw, asks ? SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT : SSL_VERIFY_NONE,
                       nullptr);
    return context;
}

}  // namespace

Result<TlsContext> TlsContext::server(const TlsFiles& files) {
    TlsContext context;
    ANATOMESH_TRY(context.context_, make_context(files, true));
    return context;
}
Result<TlsContext> TlsContext::client(const TlsFiles& files) {
    TlsContext context;
    ANATOMESH_TRY(context.context_, make_context(files, false));
    return context;
}

Stream::Stream(int descriptor) : descriptor_(descriptor) {}

Stream::Stream(int descriptor, const TlsContext& tls, bool is_server, const std::string& host)
    : descriptor_(descriptor), tls_(SSL_new(tls.get())) {
    if (!tls_) return;
    SSL_set_fd(tls_, descriptor);
    if (is_server) {
        SSL_set_accept_state(tls_);
        return;
    }
    SSL_set_connect_state(tls_);
    X509_VERIFY_PARAM* checked = SSL_get0_param(tls_);
    if (X509_VERIFY_PARAM_set1_ip_asc(checked, host.c_str()) != 1) {
        X509_VERIFY_PARAM_set1_host(checked, host.c_str(), host.size());
        SSL_set_tlsext_host_name(tls_, host.c_str());
    }
    ERR_clear_error();
}

Stream::Stream(Stream&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      tls_(std::exchange(other.tls_, nullptr)),
      reason_(std::move(other.reason_)) {}

Stream::~Stream() {
    if (tls_) SSL_free(tls_);
    if (descriptor_ >= 0) ::close(descriptor_);
}

StreamState Stream::tls_state(int result) {
    switch (SSL_get_error(tls_, result)) {
        case SSL_ERROR_WANT_READ:
            return StreamState::wants_read;
        case SSL_ERROR_WANT_WRITE:
            return StreamState::wants_write;
        case SSL_ERROR_ZERO_RETURN:
            return StreamState::closed;
        default: {
            const long verified = SSL_get_verify_result(tls_);
            reason_ = verified != X509_V_OK ? X509_verify_cert_error_string(verified) : tls_reason();
            ERR_clear_error();
            return StreamState::failed;
        }
    }
}

StreamState Stream::read(char* into, std::size_t size, std::size_t& got) {
    if (tls_) {
        const int result = SSL_read_ex(tls_, into, size, &got);
        return result == 1 ? StreamState::done : tls_state(result);
    }
    while (true) {
        const ssize_t count = ::recv(descriptor_, into, size, 0);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return StreamState::wants_read;
        if (count < 0) {
            reason_ = std::strerror(errno);
            return StreamState::failed;
        }
        got = static_cast<std::size_t>(count);
        return count == 0 ? StreamState::closed : StreamState::done;
    }
}

StreamState Stream::write(std::string_view bytes, std::size_t& put) {
    if (tls_) {
        const int result = SSL_write_ex(tls_, bytes.data(), bytes.size(), &put);
        return result == 1 ? StreamState::done : tls_state(result);
    }
    while (true) {
        const ssize_t count = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return StreamState::wants_write;
        if (count < 0) {
            reason_ = std::strerror(errno);
            return StreamState::failed;
        }
        put = static_cast<std::size_t>(count);
        return StreamState::done;
    }
}

void Stream::shut_down() {
    if (tls_ && SSL_is_init_finished(tls_)) {
        SSL_shutdown(tls_);
        ERR_clear_error();
    }
    ::shutdown(descriptor_, SHUT_WR);
}

Result<Listener> listen_at(const std::string& address, std::uint16_t port) {
    const AddressList addresses(address, port, AI_PASSIVE);
    const auto refuse = [&](const std::string& reason) {
        return network_error("E-NET-003", "the program cannot listen at the port: " + reason,
                             address + " port " + std::to_string(port),
                             "choose another --port (above 1023) or --address");
    };
    if (!addresses.first()) return refuse(addresses.failure());
    const addrinfo& where = *addresses.first();
    Listener listener;
    listener.descriptor = ::socket(where.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (listener.descriptor < 0) return refuse(std::strerror(errno));
    const int yes = 1;
    ::setsockopt(listener.descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    if (::bind(listener.descriptor, where.ai_addr, where.ai_addrlen) != 0 ||
        ::listen(listener.descriptor, 128) != 0 ||
        ::getsockname(listener.descriptor, reinterpret_cast<sockaddr*>(&bound), &size) != 0) {
        const std::string reason = std::strerror(errno);
        ::close(listener.descriptor);
        return refuse(reason);
    }
    listener.port = ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(bound).sin6_port
                                                      : reinterpret_cast<sockaddr_in&>(bound).sin_port);
    return listener;
}

int accept_from(int listener, std::string& peer) {
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    const int descriptor =
        ::accept4(listener, reinterpret_cast<sockaddr*>(&from), &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (descriptor < 0) return -1;
    make_prompt(descriptor);
    peer = numeric_address(reinterpret_cast<sockaddr*>(&from), size);
    return descriptor;
}

Result<int> connect_to(const std::string& host, std::uint16_t port, Clock::time_point deadline,
                       const RunContext& context) {
    const AddressList addresses(host, port, 0);
    std::string reason = addresses.failure();
    for (const addrinfo* each = addresses.first(); each; each = each->ai_next) {
        const int descriptor = ::socket(each->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        if (descriptor < 0) continue;
        int failure = 0;
        if (::connect(descriptor, each->ai_addr, each->ai_addrlen) != 0)
            failure = errno == EINPROGRESS ? wait_for_connection(descriptor, deadline, context) : errno;
        if (failure == 0) {
            make_prompt(descriptor);
            return descriptor;
        }
        ::close(descriptor);
        if (context.cancelled()) return cancelled_error();
        reason = std::strerror(failure);
    }
    return network_error("E-NET-010", "the connection failed: " + reason,
                         host + " port " + std::to_string(port),
                         "check host and port, and that the other side is running");
}

std::vector<std::string> addresses_of(const std::string& host) {
    const AddressList addresses(host, 0, 0);
    std::vector<std::string> found;
    for (const addrinfo* each = addresses.first(); each; each = each->ai_next)
        found.push_back(numeric_address(each->ai_addr, each->ai_addrlen));
    return found;
}

bool is_loopback(const std::string& address) {
    return address == "::1" || address.starts_with("127.");
}

}  // namespace anatomesh
