// A peer on the network, as the command line names it, and how to talk to it.
#pragma once

#include <optional>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh_io/network/request_budget.h"
#include "anatomesh_io/network/requestor.h"
#include "anatomesh_io/network/stream.h"

namespace anatomesh {

// A DICOM peer, or the base URL of a DICOMweb service.
struct Peer {
    std::optional<DicomPeer> dicom;
    std::string url;  // "http://host:8042/dicom-web", without a slash at its end
};

// "AE@HOST:PORT", the port 104 when it is left out, an IPv6 address in brackets; or "http://..." or
// "https://...", without user, query or fragment. Error (usage): E-NET-005.
Result<Peer> parse_peer(const std::string& text);

struct ConnectOptions {
    Peer peer;
    std::string title = "ANATOMESH";  // by which this side calls itself
    double timeout_seconds = 30;      // of silence. > 0
    bool use_tls = false;             // of a DICOM peer; a URL says it itself
    TlsFiles tls;
    std::string user, password;  // of DICOMweb
    RequestLimits limits;
};

}  // namespace anatomesh
