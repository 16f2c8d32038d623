#include "anatomesh_io/network/http_client.h"

#include <httplib.h>

#include <cmath>

namespace anatomesh {

namespace {

// No more of an answer is kept, so that a hostile server takes no memory. [bytes; >= 65536; B]
constexpr std::size_t longest_http_answer = std::size_t{64} << 20;

std::string in_words(httplib::Error error) {
    switch (error) {
        case httplib::Error::Connection:
            return "no connection";
        case httplib::Error::ConnectionTimeout:
            return "no connection within the time";
        case httplib::Error::Read:
            return "no answer, or not the whole of it";
        case httplib::Error::Write:
            return "the request cannot be sent";
        case httplib::Error::SSLConnection:
            return "no TLS connection";
        case httplib::Error::SSLLoadingCerts:
            return "the certificates for TLS cannot be read";
        case httplib::Error::SSLServerVerification:
            return "the service's certificate is not trusted";
        default:
            return "no answer: " + httplib::to_string(error);
    }
}

}  // namespace

struct HttpClient::Door {
    ConnectOptions options;
    const RunContext& context;
    std::string base;  // path of the base URL
    httplib::Client client;

    Door(const ConnectOptions& from, const RunContext& run, const std::string& origin,
         const std::string& path)
        : options(from), context(run), base(path), client(origin, from.tls.certificate, from.tls.key) {}

    // Nothing: an answer came. `stopped`: this side ended the answer before its end.
    Status outcome(const httplib::Result& result, bool stopped) const {
        if (context.cancelled()) return cancelled_error();
        if (result || stopped) return Nothing{};
        return Error{ErrorKind::file,
                     "E-NET-016",
                     in_words(result.error()),
                     {"", "", "", "", options.peer.url},
                     "check the URL, and that the service is running"};
    }
};

HttpClient::HttpClient(const ConnectOptions& options, const RunContext& context) {
    const std::string& url = options.peer.url;
    const std::size_t host = url.find("://") + 3;
    const std::size_t path = std::min(url.find('/', host), url.size());
    door_ = std::make_unique<Door>(options, context, url.substr(0, path), url.substr(path));
    httplib::Client& client = door_->client;
    const auto seconds = static_cast<time_t>(std::ceil(options.timeout_seconds));
    client.set_connection_timeout(seconds);
    client.set_read_timeout(seconds);
    client.set_write_timeout(seconds);
    client.set_follow_location(false);
    client.set_tcp_nodelay(true);
    client.set_keep_alive(true);
    if (!options.tls.authorities.empty()) client.set_ca_cert_path(options.tls.authorities);
    client.enable_server_certificate_verification(true);
    if (!options.user.empty()) client.set_basic_auth(options.user, options.password);
}

HttpClient::~HttpClient() = default;

Result<HttpReply> HttpClient::get(const std::string& path, const std::string& accept,
                                  const Receiver& receiver) {
    HttpReply reply;
    bool stopped = false;
    const httplib::Result result = door_->client.Get(
        door_->base + path, httplib::Headers{{"Accept", accept}},
        [&](const httplib::Response& response) {
            reply = {response.status, response.get_header_value("Content-Type")};
            stopped = !receiver.begin(reply);
            return !stopped;
        },
        [&](const char* bytes, std::size_t size) {
            stopped = door_->context.cancelled() || !receiver.data({bytes, size});
            return !stopped;
        });
    ANATOMESH_CHECK_STATUS(door_->outcome(result, stopped));
    // An answer without content begins nothing.
    if (result) reply = {result->status, result->get_header_value("Content-Type")};
    return reply;
}

Result<HttpReply> HttpClient::post(const std::string& path, const std::string& content_type,
                                   const std::string& accept, std::uint64_t size, const Read& read,
                                   std::string& answer) {
    const httplib::Result result = door_->client.Post(
        door_->base + path, httplib::Headers{{"Accept", accept}}, size,
        [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
            if (door_->context.cancelled()) return false;
            const std::string_view piece = read(offset, length);
            return !piece.empty() && sink.write(piece.data(), piece.size());
        },
        content_type);
    ANATOMESH_CHECK_STATUS(door_->outcome(result, false));
    answer = result->body.substr(0, longest_http_answer);
    return HttpReply{result->status, result->get_header_value("Content-Type")};
}

Error HttpClient::refused(const HttpReply& reply, const std::string& what) const {
    const bool is_login = reply.status == 401 || reply.status == 403;
    return {ErrorKind::file,
            "E-NET-017",
            "the service answers " + what + " with HTTP status " + std::to_string(reply.status),
            {"", "", "", "", door_->options.peer.url},
            is_login ? "check --user and --password-file" : "check the URL and the UIDs"};
}

std::string url_escaped(std::string_view text) {
    constexpr char digits[] = "0123456789ABCDEF";
    std::string out;
    for (const char c : text) {
        const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                              std::string_view("-_.~").find(c) != std::string_view::npos;
        if (is_plain) {
            out += c;
            continue;
        }
        out += '%';
        out += digits[static_cast<unsigned char>(c) >> 4];
        out += digits[static_cast<unsigned char>(c) & 15];
    }
    return out;
}

}  // namespace anatomesh
