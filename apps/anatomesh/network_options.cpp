#include "network_options.h"

#include <fmt/format.h>

#include "anatomesh_io/file/input_file.h"
#include "help_text.h"
#include "option_values.h"

namespace anatomesh {

namespace {

Error does_not_apply_to_peer(const std::string& option, const std::string& peer, const std::string& why) {
    return {ErrorKind::usage,
            "E-CMD-008",
            fmt::format("{} does not apply: {}", option, why),
            {"", "", "", "", peer},
            fmt::format("leave out {}", option)};
}

// The first line of a file.
Result<std::string> read_password(const std::string& path) {
    // A password's file is no longer. [bytes; >= 64; B]
    constexpr std::size_t longest = 4096;
    ANATOMESH_TRY(const std::vector<std::byte> bytes, read_input_start(path, longest));
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.substr(0, text.find_first_of("\r\n"));
}

}  // namespace

void add_title_option(CLI::App& verb, std::string& title) {
    verb.add_option_function<std::string>(
            "--title",
            [&title](const std::string& text) {
                if (!is_ae_title(text))
                    throw CLI::ValidationError(
                        "--title",
                        fmt::format("'{}' is no AE title: 1 to 16 ASCII characters, no backslash", text));
                title = text;
            },
            "DICOM name (AE title) of this program. Default: ANATOMESH.")
        ->type_name("AE");
}

void add_timeout_option(CLI::App& verb, double& seconds) {
    add_number(verb, "--timeout", seconds, 0.1, 3600, "SECONDS",
               "Give up if the other side is silent for this long, 0.1 to 3600 s. Default: 30.");
}

void add_quota_option(CLI::App& verb, double& megabytes) {
    add_number(verb, "--quota", megabytes, 0.001, 1e9, "MB",
               "Largest size of the folder in megabytes, 0.001 to 1e9. Default: no limit.");
}

void add_tls_files(CLI::App& verb, TlsFiles& files) {
    add_text(verb, "--tls-certificate", files.certificate, "FILE",
             "Certificate of this program for TLS, a PEM file.");
    add_text(verb, "--tls-key", files.key, "FILE", "Private key of the certificate, a PEM file.");
    add_text(verb, "--tls-authorities", files.authorities, "FILE",
             "Authorities that must have signed the other side's certificate, a PEM file. Default: those of "
             "the system.");
}

void add_network_options(CLI::App& verb, const std::string& name, NetworkOptions& options) {
    add_text(verb, name, options.peer, "PEER",
             "The archive or other program to talk to: AE@HOST:PORT, or the URL of a DICOMweb service.")
        ->required();
    group_new_options(verb, option_group::request);
    add_title_option(verb, options.title);
    add_timeout_option(verb, options.timeout_seconds);
    CLI::Option* timeout = verb.get_option("--timeout");
    timeout->description(
        timeout->get_description() +
        fmt::format(" A request takes at most {} s and {} GiB in all; --limit request-seconds=N and --limit "
                    "request-bytes=N set this.",
                    most_request_seconds, most_request_bytes >> 30));
    verb.add_flag("--tls", options.use_tls, "Encrypt the connection to AE@HOST:PORT by TLS.");
    add_tls_files(verb, options.tls);
    add_text(verb, "--user", options.user, "NAME", "User name at the DICOMweb service.");
    add_text(verb, "--password-file", options.password_file, "FILE",
             "File whose first line is the password of --user.");
    group_new_options(verb, option_group::connection);
}

Error usage_error(const char* code, std::string message, std::string value, std::string next_step) {
    return {
        ErrorKind::usage, code, std::move(message), {"", "", "", "", std::move(value)}, std::move(next_step)};
}

Result<ConnectOptions> connect_options(const NetworkOptions& options, const RequestLimits& limits) {
    ConnectOptions connecting;
    ANATOMESH_TRY(connecting.peer, parse_peer(options.peer));
    const bool is_web = !connecting.peer.dicom;
    if (is_web && options.use_tls)
        return does_not_apply_to_peer("--tls", options.peer, "a URL with https:// says it");
    if (!is_web && !options.user.empty())
        return does_not_apply_to_peer("--user", options.peer, "DICOM peers know AE titles, no users");
    if (options.user.empty() && !options.password_file.empty())
        return does_not_apply_to_peer("--password-file", options.peer, "there is no --user");
    const bool is_plain = is_web ? options.peer.starts_with("http://") : !options.use_tls;
    if (is_plain && !options.tls.empty())
        return does_not_apply_to_peer("--tls-certificate, --tls-key or --tls-authorities", options.peer,
                                      "this peer is talked to without TLS");
    connecting.title = options.title;
    connecting.timeout_seconds = options.timeout_seconds;
    connecting.limits = limits;
    connecting.use_tls = options.use_tls;
    connecting.tls = options.tls;
    connecting.user = options.user;
    if (!options.password_file.empty()) {
        ANATOMESH_TRY(connecting.password, read_password(options.password_file));
    }
    return connecting;
}

}  // namespace anatomesh
