// fetch_objects: a study, series or instance from an archive into a folder: C-GET, C-MOVE, or WADO-RS.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/network/object_store.h"
#include "anatomesh_io/network/peer.h"

namespace anatomesh {

struct FetchOptions {
    std::string study, series, instance;  // UIDs; a series needs its study, an instance its series
    // C-MOVE instead of C-GET: to this AE title. With a port this program is it, and listens there.
    std::string move_to;
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;  // 0: another program is the destination
};

// An object that came and was not stored.
struct RefusedObject {
    std::string path;  // its place in the folder; empty: it does not say who it is
    std::string reason;
};

struct FetchResult {
    std::uint64_t stored = 0, there_already = 0, refused = 0, bytes = 0;  // in our folder
    std::uint64_t unasked = 0;            // came, but of other UIDs than were asked for: they are not stored
    std::uint64_t sent = 0, failed = 0;   // as the peer counts
    std::vector<std::string> reasons;     // why objects were refused here, each once
    std::vector<RefusedObject> refusals;  // the first ten
};

// All of it is one request to the peer as far as `from.limits` is concerned. Only objects of the UIDs in `options` are stored. From then on the store takes no others.
//
// `store` may be null when another program is the destination of a C-MOVE. Errors: those of Requestor,
// HttpClient and receive_objects; E-NET-019 the peer refuses.
Result<FetchResult> fetch_objects(ObjectStore* store, const FetchOptions& options, const ConnectOptions& from,
                                  const RunContext& context);

}  // namespace anatomesh
