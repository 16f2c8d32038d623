#include "anatomesh_io/network/peer.h"

#include <algorithm>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

Error wrong_peer(const std::string& text, const std::string& what) {
    return {ErrorKind::usage,
            "E-NET-005",
            what,
            {"", "", "", "", text.substr(0, 200)},
            "a DICOM peer is written AE@HOST:PORT, DICOMweb http://HOST:PORT/PATH or https://..."};
}

bool is_plain(const std::string& text) {
    return !text.empty() && text.size() <= 2000 &&
           std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7F; });
}

Result<Peer> parse_url(const std::string& text) {
    if (text.find_first_of("?#") != std::string::npos)
        return wrong_peer(text, "the URL of a service has no query and no fragment");
    const std::size_t host = text.find("://") + 3;
    const std::size_t path = std::min(text.find('/', host), text.size());
    const std::string authority = text.substr(host, path - host);
    if (authority.empty() || authority.front() == ':') return wrong_peer(text, "the URL names no host");
    if (authority.find('@') != std::string::npos)
        return wrong_peer(text.substr(0, host) + "...",
                          "a URL with a user in it is seen by all users; use --user");
    Peer peer;
    peer.url = text;
    while (peer.url.back() == '/') peer.url.pop_back();
    return peer;
}

}  // namespace

Result<Peer> parse_peer(const std::string& text) {
    if (!is_plain(text)) return wrong_peer(text, "the name of the peer is empty, or holds blanks");
    if (text.starts_with("http://") || text.starts_with("https://")) return parse_url(text);
    const std::size_t at = text.find('@');
    if (at == std::string::npos) return wrong_peer(text, "the AE title of the peer is missing");
    DicomPeer dicom;
    dicom.title = text.substr(0, at);
    if (!is_ae_title(dicom.title))
        return wrong_peer(text, "an AE title has 1 to 16 ASCII characters and no backslash");
    std::string where = text.substr(at + 1), port;
    if (where.starts_with('[')) {
        const std::size_t close = where.find(']');
        if (close == std::string::npos) return wrong_peer(text, "the bracket of an address does not close");
        dicom.host = where.substr(1, close - 1);
        port = where.substr(close + 1);
    } else {
        const std::size_t colon = where.find(':');
        dicom.host = where.substr(0, colon);
        if (colon != std::string::npos) port = where.substr(colon);
    }
    if (dicom.host.empty()) return wrong_peer(text, "the host of the peer is missing");
    if (!port.empty()) {
        const auto number = port.front() == ':' && port.size() > 1 && port[1] != '+'
                                ? parse_integer<std::uint16_t>(port.substr(1))
                                : std::nullopt;
        if (!number || *number == 0) return wrong_peer(text, "a port is a number from 1 to 65535");
        dicom.port = *number;
    }
    Peer peer;
    peer.dicom = dicom;
    return peer;
}

}  // namespace anatomesh
