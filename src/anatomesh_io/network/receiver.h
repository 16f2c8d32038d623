// receive_objects: a DICOM receiver (C-STORE and C-ECHO) for many peers at once, none of which can hold up
// another: one thread, sockets that never block.
//
// Who does not associate within the timeout is closed. Of more than `associations` at a time the next is
// rejected for now. A crowd of silent connections pushes out the oldest silent ones, never an association.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/network/object_store.h"
#include "anatomesh_io/network/stream.h"

namespace anatomesh {

// Who may send: an AE title from an address. Empty title: any. Addresses as text; none: any host.
struct AllowedPeer {
    std::string title;
    std::vector<std::string> addresses;
};

struct ReceiverOptions {
    std::string title = "ANATOMESH";    // the AE title that peers must call
    std::string address = "127.0.0.1";  // to listen at
    std::uint16_t port = 11112;         // 0: any that is free
    std::vector<AllowedPeer> allowed;   // none: anybody on this machine
    std::uint32_t associations = 8;     // at a time. >= 1
    double timeout_seconds = 30;        // of silence, and until the peer has associated. > 0
    double association_seconds = 600;   // beyond it a peer must keep up least_rate
    double least_rate = 65536;          // bytes a second
    const TlsContext* tls = nullptr;
};

struct ReceiverHooks {
    std::function<void(std::uint16_t port)> listening;
    // A line on what happened; at most ten a minute of a peer. Holds no UID and no name of a patient.
    std::function<void(const std::string&)> log;
    std::function<void(const StoreOutcome&)> ended;  // of every object
    // Several times a second. `busy` holds the studies that came in lately, as StoreOutcome calls them, while
    // their associations are open. Returns whether to end.
    std::function<bool(const std::vector<std::string>& busy)> tick;
};

struct ReceiverSummary {
    std::uint64_t associations = 0, rejected = 0, stored = 0, there_already = 0, refused = 0, bytes = 0;
};

// Receives until the context is cancelled or tick() ends it; both are a regular end, after which associations
// are aborted. Errors: E-NET-003.
Result<ReceiverSummary> receive_objects(ObjectStore& store, const ReceiverOptions& options,
                                        const ReceiverHooks& hooks, const RunContext& context);

}  // namespace anatomesh
