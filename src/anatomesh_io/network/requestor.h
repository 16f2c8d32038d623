// Requestor: one association as the asking side has it, and the services over it: C-ECHO, C-STORE, C-FIND,
// C-GET, C-MOVE. Every wait ends: by the peer's silence, or when the run is cancelled; every request ends within
// its limits. No more than 1 MiB of an answer is kept.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/network/acceptor.h"
#include "anatomesh_io/network/dimse.h"
#include "anatomesh_io/network/pdu.h"
#include "anatomesh_io/network/request_budget.h"
#include "anatomesh_io/network/stream.h"

namespace anatomesh {

// A DICOM peer: AE@HOST:PORT.
struct DicomPeer {
    std::string title, host;
    std::uint16_t port = 104;
};

struct RequestorOptions {
    DicomPeer peer;
    std::string title = "ANATOMESH";  // by which this side calls itself
    double timeout_seconds = 30;      // of the peer's silence. > 0
    const TlsContext* tls = nullptr;
    RequestLimits limits;  // of each request; associating is one
};

// How many sub-operations a C-GET or C-MOVE came to.
struct RetrieveCounts {
    std::uint16_t completed = 0, failed = 0, warned = 0;
};

class Requestor {
  public:
    // Associates. Contexts are numbered 1, 3, 5 ... in the order given; at most 128, of which at least one
    // must be accepted. Errors (file): E-NET-010 no connection, E-NET-011 rejected, E-NET-012 no context
    // accepted, E-NET-013 the peer was silent, aborted, or does not speak DICOM; those of RequestBudget.
    static Result<Requestor> associate(const RequestorOptions& options,
                                       std::vector<PresentationContext> contexts,
                                       std::vector<RoleSelection> roles, const RunContext& context);

    // The accepted contexts; each with its one transfer syntax.
    const std::vector<PresentationContext>& contexts() const { return accepted_; }
    // The accepted context of a class and syntax (empty: any syntax).
    const PresentationContext* context_of(std::string_view sop_class, std::string_view syntax = {}) const;

    // Each gives the status of the reply. Errors: E-NET-013; those of RequestBudget; cancelled.
    Result<std::uint16_t> echo();
    Result<std::uint16_t> store(const PresentationContext& context, const std::string& sop_instance,
                                std::string_view data_set);

    // `matched` gets every answer, a data set in the transfer syntax of the context; it returns whether to go
    // on: otherwise the query is cancelled.
    using Matched = std::function<bool(std::string_view data_set)>;
    Result<std::uint16_t> find(const PresentationContext& context, std::string_view identifier,
                               const Matched& matched);

    // The peer sends the objects over this association; each goes to a sink.
    using OpenSink = std::function<std::unique_ptr<ObjectSink>(const ObjectLabel&)>;
    using Progress = std::function<void(const Command& reply)>;
    Result<std::uint16_t> get(const PresentationContext& context, std::string_view identifier,
                              const OpenSink& open, RetrieveCounts& counts, const Progress& progress);
    // The peer sends them to the AE title `destination`.
    Result<std::uint16_t> move(const PresentationContext& context, std::string_view identifier,
                               const std::string& destination, RetrieveCounts& counts,
                               const Progress& progress);

    // Ends the association in good order, as far as the peer takes part.
    void release();

  private:
    class Inbox;

    Requestor(Stream stream, const RequestorOptions& options, RequestBudget budget, const RunContext& context)
        : stream_(std::move(stream)), options_(options), budget_(std::move(budget)), context_(&context) {}

    void begin_budget();
    Status send(std::string_view bytes);
    Status send_command(std::uint8_t context, const Command& command);
    // A command of this class, numbered, with its identifier.
    Status send_request(const PresentationContext& context, Command& request, std::string_view identifier);
    Status receive_some(std::string& into);
    Status receive_pdu(PduType& type, std::string& body);
    Status negotiate(const std::vector<PresentationContext>& asked, const std::vector<RoleSelection>& roles);
    // The fragments of the next unit of data.
    Status receive_fragments();
    // One fragment after another into the inbox until it has a whole message.
    Status receive_message(Inbox& inbox);
    Result<std::uint16_t> retrieve(const PresentationContext& context, Command request,
                                   std::string_view identifier, const OpenSink& open, RetrieveCounts& counts,
                                   const Progress& progress);
    Error lost(const std::string& why) const;

    Stream stream_;
    RequestorOptions options_;
    RequestBudget budget_;
    const RunContext* context_;
    std::vector<PresentationContext> accepted_;
    std::uint32_t longest_pdu_ = 0;
    std::uint16_t message_ = 0;
    std::string input_;
    std::string body_;  // of the unit whose fragments these are
    std::vector<DataFragment> fragments_;
    std::size_t next_fragment_ = 0;
};

}  // namespace anatomesh
