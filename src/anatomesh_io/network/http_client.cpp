#include "anatomesh_io/network/http_client.h"

#include <httplib.h>

#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "anatomesh_io/network/socket_watch.h"

namespace anatomesh {

namespace {

// A longer answer to what was sent is refused, so that a hostile server takes no memory. [bytes; >= 65536; B]
constexpr std::size_t longest_http_answer = std::size_t{64} << 20;
// No more bytes of headers and of the framing of chunks may come without any content among them: the library
// keeps headers, and lines that do not end, in memory. [bytes; >= 1048576; B]
constexpr std::uint64_t most_framing_bytes = std::uint64_t{16} << 20;

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
    SocketWatch watch;

    Door(const ConnectOptions& from, const RunContext& run, const std::string& origin,
         const std::string& path)
        : options(from), context(run), base(path), client(origin, from.tls.certificate, from.tls.key) {}

    Error error(const char* code, const std::string& message, const char* next_step) const {
        return {ErrorKind::file, code, message, {"", "", "", "", options.peer.url}, next_step};
    }
    Result<HttpReply> send(httplib::Request request, const Receiver& receiver);
};

Result<HttpReply> HttpClient::Door::send(httplib::Request request, const Receiver& receiver) {
    HttpReply reply;
    bool stopped = false;
    RequestBudget budget(options.limits, options.peer.url);
    Status within_budget = Nothing{};
    std::atomic<std::uint64_t> delivered{0};
    request.response_handler = [&](const httplib::Response& response) {
        reply = {response.status, response.get_header_value("Content-Type")};
        stopped = !receiver.begin(reply);
        return !stopped;
    };
    request.content_receiver = [&](const char* bytes, std::size_t size, std::uint64_t, std::uint64_t) {
        delivered += size;
        within_budget = budget.spend_bytes(size);
        stopped = !within_budget.ok() || context.cancelled() || !receiver.data({bytes, size});
        return !stopped;
    };
    std::uint64_t delivered_before = 0, taken_before = 0;
    ANATOMESH_CHECK_STATUS(watch.begin([&](std::uint64_t taken) -> std::optional<Error> {
        if (context.cancelled()) return cancelled_error();
        const Status in_time = budget.check_time();
        if (!in_time.ok()) return in_time.error();
        if (std::exchange(delivered_before, delivered.load()) != delivered || taken < taken_before)
            taken_before = taken;
        if (taken - taken_before > most_framing_bytes)
            return error("E-NET-018", "more than 16 MiB of headers come without any content",
                         "check that the URL is that of a DICOMweb service");
        return std::nullopt;
    }));
    const httplib::Result result = client.send(request);
    std::optional<Error> ended = watch.end();
    if (context.cancelled()) return cancelled_error();
    if (ended) return std::move(*ended);
    if (!within_budget.ok()) return within_budget.error();
    if (!result && !stopped)
        return error("E-NET-016", in_words(result.error()), "check the URL, and that the service is running");
    // An answer without content begins nothing.
    if (result) reply = {result->status, result->get_header_value("Content-Type")};
    return reply;
}

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
    client.set_socket_options([watch = &door_->watch](int descriptor) { watch->follow(descriptor); });
    if (!options.user.empty()) client.set_basic_auth(options.user, options.password);
}

HttpClient::~HttpClient() = default;

Result<HttpReply> HttpClient::get(const std::string& path, const std::string& accept,
                                  const Receiver& receiver) {
    httplib::Request request;
    request.method = "GET";
    request.path = door_->base + path;
    request.headers = {{"Accept", accept}};
    return door_->send(std::move(request), receiver);
}

Result<HttpReply> HttpClient::post(const std::string& path, const std::string& content_type,
                                   const std::string& accept, std::uint64_t size, const Read& read,
                                   std::string& answer) {
    httplib::Request request;
    request.method = "POST";
    request.path = door_->base + path;
    request.headers = {{"Accept", accept}, {"Content-Type", content_type}};
    request.content_length_ = size;
    request.content_provider_ = [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        if (door_->context.cancelled()) return false;
        const std::string_view piece = read(offset, length);
        return !piece.empty() && sink.write(piece.data(), piece.size());
    };
    bool is_too_long = false;
    const Receiver receiver{[](const HttpReply&) { return true; },
                            [&](std::string_view bytes) {
                                is_too_long = bytes.size() > longest_http_answer - answer.size();
                                if (!is_too_long) answer += bytes;
                                return !is_too_long;
                            }};
    answer.clear();
    ANATOMESH_TRY(const HttpReply reply, door_->send(std::move(request), receiver));
    if (is_too_long)
        return door_->error("E-NET-018", "the answer is longer than 64 MiB",
                            "look into the log of the service; send fewer objects at a time");
    return reply;
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
