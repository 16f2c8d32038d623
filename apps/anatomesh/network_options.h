// What the verbs that talk to peers have in common: naming the peer, this side's AE title, time, TLS, a
// password.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh_io/network/peer.h"

namespace anatomesh {

struct NetworkOptions {
    std::string peer, title = "ANATOMESH", user, password_file;
    double timeout_seconds = 30;
    bool use_tls = false;
    TlsFiles tls;
};

// --from or --to (`name`), --title, --timeout, --tls and its files, --user, --password-file.
void add_network_options(CLI::App& verb, const std::string& name, NetworkOptions& options);
// --title, --timeout and the files of TLS alone.
void add_title_option(CLI::App& verb, std::string& title);
void add_timeout_option(CLI::App& verb, double& seconds);
// --quota, of the folder that objects go to.
void add_quota_option(CLI::App& verb, double& megabytes);
void add_tls_files(CLI::App& verb, TlsFiles& files);

// A wrong use of the command line; `value`: what was given.
Error usage_error(const char* code, std::string message, std::string value, std::string next_step);

// Reads the password. Errors: E-NET-005 the peer; E-CMD-008 an option that does not apply to it; E-INP-* the
// password file.
Result<ConnectOptions> connect_options(const NetworkOptions& options, const RequestLimits& limits);

}  // namespace anatomesh
