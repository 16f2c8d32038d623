#include "anatomesh_io/network/requestor.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <utility>

namespace anatomesh {

namespace {

// A longer answer to a query is refused, so that a hostile peer takes no memory. [bytes; >= 65536; B]
constexpr std::size_t longest_answer = std::size_t{1} << 20;
// The end of an association is waited for no longer: all objects are there already. [s; > 0; B]
constexpr double release_seconds = 5;

std::string name_of(const DicomPeer& peer) {
    return peer.title + "@" + peer.host + ":" + std::to_string(peer.port);
}

}  // namespace

// What comes in over an association: replies, with their data sets, and the objects of a C-GET.
class Requestor::Inbox : public MessageAssembler::Sink {
  public:
    explicit Inbox(OpenSink open = {}) : open_(std::move(open)) {}

    Command message;
    std::uint8_t context = 0;
    std::string data_set;  // of a reply
    std::uint16_t store_status = 0;
    bool is_whole = false, is_too_long = false;
    const PresentationContext* stored_context = nullptr;
    std::function<const PresentationContext*(std::uint8_t)> find_context;

    void begin() {
        is_whole = false;
        data_set.clear();
        sink_.reset();
        store_status = dimse::no_such_operation;
    }
    MessageAssembler& assembler() { return assembler_; }

  private:
    void command(std::uint8_t id, const Command& command) override {
        message = command;
        context = id;
        is_whole = !command.has_data_set;
        if (command.field != dimse::store_request || !open_) return;
        const PresentationContext* with = find_context(id);
        if (!with || !command.has_data_set || command.sop_instance.empty())
            store_status = dimse::cannot_understand;
        else if (command.sop_class != with->abstract_syntax)
            store_status = dimse::does_not_match_class;
        else
            sink_ = open_({command.sop_class, command.sop_instance, with->transfer_syntaxes[0]});
    }
    void data(std::string_view bytes) override {
        if (sink_) return sink_->write(bytes);
        if (message.field == dimse::store_request || is_too_long) return;
        is_too_long = bytes.size() > longest_answer - data_set.size();
        if (!is_too_long) data_set += bytes;
    }
    void end_of_data() override {
        if (sink_) store_status = sink_->finish();
        sink_.reset();
        is_whole = true;
    }

    OpenSink open_;
    MessageAssembler assembler_;
    std::unique_ptr<ObjectSink> sink_;
};

Error Requestor::lost(const std::string& why) const {
    return {ErrorKind::file,
            "E-NET-013",
            "the connection (association) ended: " + why,
            {"", "", "", "", name_of(options_.peer)},
            "look into the peer's log; try again"};
}

Status Requestor::send(std::string_view bytes) {
    auto deadline = Clock::now() + std::chrono::duration<double>(options_.timeout_seconds);
    while (!bytes.empty()) {
        if (context_->cancelled()) return cancelled_error();
        ANATOMESH_CHECK_STATUS(budget_.check_time());
        std::size_t put = 0;
        const StreamState state = stream_.write(bytes, put);
        if (state == StreamState::done) {
            bytes.remove_prefix(put);
            deadline = Clock::now() + std::chrono::duration<double>(options_.timeout_seconds);
            continue;
        }
        if (state == StreamState::closed) return lost("the peer closed the connection");
        if (state == StreamState::failed) return lost(stream_.reason());
        if (Clock::now() > deadline) return lost("the peer takes nothing more");
        const auto events = static_cast<short>(state == StreamState::wants_read ? POLLIN : POLLOUT);
        pollfd socket{stream_.descriptor(), events, 0};
        ::poll(&socket, 1, 200);
    }
    return Nothing{};
}

Status Requestor::receive_some(std::string& into) {
    const auto deadline = Clock::now() + std::chrono::duration<double>(options_.timeout_seconds);
    std::array<char, 65536> buffer;
    while (true) {
        if (context_->cancelled()) return cancelled_error();
        ANATOMESH_CHECK_STATUS(budget_.check_time());
        std::size_t got = 0;
        const StreamState state = stream_.read(buffer.data(), buffer.size(), got);
        if (state == StreamState::done) {
            into.append(buffer.data(), got);
            return budget_.spend_bytes(got);
        }
        if (state == StreamState::closed) return lost("the peer closed the connection");
        if (state == StreamState::failed) return lost(stream_.reason());
        if (Clock::now() > deadline) return lost("the other side is silent");
        const auto events = static_cast<short>(state == StreamState::wants_write ? POLLOUT : POLLIN);
        pollfd socket{stream_.descriptor(), events, 0};
        ::poll(&socket, 1, 200);
    }
}

Status Requestor::receive_pdu(PduType& type, std::string& body) {
    while (input_.size() < pdu_header_bytes) {
        ANATOMESH_CHECK_STATUS(receive_some(input_));
    }
    const PduHeader header = parse_pdu_header(input_);
    if (header.type < 1 || header.type > 7 || header.length > longest_pdu_body)
        return lost("what the peer sends is no DICOM");
    while (input_.size() < pdu_header_bytes + header.length) {
        ANATOMESH_CHECK_STATUS(receive_some(input_));
    }
    type = static_cast<PduType>(header.type);
    body = input_.substr(pdu_header_bytes, header.length);
    input_.erase(0, pdu_header_bytes + header.length);
    if (type == PduType::abort) return lost("the peer aborted");
    return Nothing{};
}

Result<Requestor> Requestor::associate(const RequestorOptions& options,
                                       std::vector<PresentationContext> contexts,
                                       std::vector<RoleSelection> roles, const RunContext& context) {
    assert(!contexts.empty() && contexts.size() <= most_presentation_contexts && options.timeout_seconds > 0);
    std::uint8_t id = 1;
    for (PresentationContext& each : contexts) each.id = std::exchange(id, static_cast<std::uint8_t>(id + 2));
    RequestBudget budget(options.limits, name_of(options.peer));
    ANATOMESH_CHECK_STATUS(budget.check_time());
    const double seconds = std::min(options.timeout_seconds, options.limits.seconds);
    const auto deadline =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    ANATOMESH_TRY(const int descriptor, connect_to(options.peer.host, options.peer.port, deadline, context));
    Requestor requestor(
        options.tls ? Stream(descriptor, *options.tls, false, options.peer.host) : Stream(descriptor),
        options, std::move(budget), context);
    ANATOMESH_CHECK_STATUS(requestor.negotiate(contexts, roles));
    return requestor;
}

Status Requestor::negotiate(const std::vector<PresentationContext>& asked,
                            const std::vector<RoleSelection>& roles) {
    Association request;
    request.called = options_.peer.title;
    request.calling = options_.title;
    request.contexts = asked;
    request.roles = roles;
    request.longest_pdu = longest_pdu_body;
    ANATOMESH_CHECK_STATUS(send(format_associate(PduType::associate_request, request)));
    PduType type = PduType::abort;
    std::string body;
    ANATOMESH_CHECK_STATUS(receive_pdu(type, body));
    if (type == PduType::associate_reject) {
        const std::optional<Rejection> rejection = parse_reject(body);
        return Error{
            ErrorKind::file,
            "E-NET-011",
            "the other side rejects the connection (association): " +
                (rejection ? text_of(*rejection) : std::string("no reason given")),
            {"", "", "", "", name_of(options_.peer)},
            "check both AE titles in the settings of the other side; --title sets that of this program"};
    }
    if (type != PduType::associate_accept) return lost("the peer does not keep to the protocol");
    const auto answer = parse_associate(PduType::associate_accept, body);
    if (!answer) return lost("the peer's answer is malformed");
    longest_pdu_ = answer->longest_pdu;
    for (const PresentationContext& each : answer->contexts) {
        const auto of_id = [&](const PresentationContext& other) { return other.id == each.id; };
        const auto mine = std::find_if(asked.begin(), asked.end(), of_id);
        if (mine == asked.end() || each.result != context_accepted || each.transfer_syntaxes.size() != 1)
            continue;
        accepted_.push_back({each.id, mine->abstract_syntax, each.transfer_syntaxes, context_accepted});
    }
    if (!accepted_.empty()) return Nothing{};
    release();
    return Error{ErrorKind::file,
                 "E-NET-012",
                 "the other side does not offer this service",
                 {"", "", "", "", name_of(options_.peer)},
                 "check its settings"};
}

const PresentationContext* Requestor::context_of(std::string_view sop_class, std::string_view syntax) const {
    for (const PresentationContext& each : accepted_)
        if (each.abstract_syntax == sop_class && (syntax.empty() || each.transfer_syntaxes[0] == syntax))
            return &each;
    return nullptr;
}

Status Requestor::send_command(std::uint8_t context, const Command& command) {
    std::string out;
    append_data(out, context, true, true, format_command(command), longest_pdu_);
    return send(out);
}

Status Requestor::receive_fragments() {
    PduType type = PduType::abort;
    ANATOMESH_CHECK_STATUS(receive_pdu(type, body_));
    auto fragments = type == PduType::data ? parse_data(body_) : std::nullopt;
    if (!fragments) return lost("the peer does not keep to the protocol");
    fragments_ = std::move(*fragments);
    next_fragment_ = 0;
    return Nothing{};
}

Status Requestor::receive_message(Inbox& inbox) {
    inbox.begin();
    while (!inbox.is_whole) {
        if (next_fragment_ == fragments_.size()) {
            ANATOMESH_CHECK_STATUS(receive_fragments());
        }
        if (!inbox.assembler().feed(fragments_[next_fragment_++], inbox))
            return lost("the peer does not keep to the protocol");
        if (inbox.is_too_long) return lost("an answer of the peer is longer than it may be");
    }
    return Nothing{};
}

void Requestor::begin_budget() {
    budget_ = RequestBudget(options_.limits, name_of(options_.peer));
}

Result<std::uint16_t> Requestor::echo() {
    begin_budget();
    const PresentationContext* with = context_of(verification_class);
    assert(with);
    Command request;
    request.field = dimse::echo_request;
    request.message = ++message_;
    request.sop_class = verification_class;
    ANATOMESH_CHECK_STATUS(send_command(with->id, request));
    Inbox inbox;
    ANATOMESH_CHECK_STATUS(receive_message(inbox));
    return inbox.message.status;
}

Result<std::uint16_t> Requestor::store(const PresentationContext& context, const std::string& sop_instance,
                                       std::string_view data_set) {
    begin_budget();
    Command request;
    request.field = dimse::store_request;
    request.message = ++message_;
    request.sop_class = context.abstract_syntax;
    request.sop_instance = sop_instance;
    request.has_data_set = true;
    std::string out;
    append_data(out, context.id, true, true, format_command(request), longest_pdu_);
    // Objects are sent in pieces of this size, so that a large one is not copied as a whole.
    // [bytes; >= 4096; B]
    constexpr std::size_t piece = std::size_t{1} << 20;
    do {
        const std::string_view part = data_set.substr(0, piece);
        data_set.remove_prefix(part.size());
        append_data(out, context.id, false, data_set.empty(), part, longest_pdu_);
        ANATOMESH_CHECK_STATUS(send(out));
        out.clear();
    } while (!data_set.empty());
    Inbox inbox;
    ANATOMESH_CHECK_STATUS(receive_message(inbox));
    if (inbox.message.field != dimse::store_reply) return lost("the peer does not keep to the protocol");
    return inbox.message.status;
}

Status Requestor::send_request(const PresentationContext& context, Command& request,
                               std::string_view identifier) {
    begin_budget();
    request.message = ++message_;
    request.sop_class = context.abstract_syntax;
    request.has_data_set = true;
    std::string out;
    append_data(out, context.id, true, true, format_command(request), longest_pdu_);
    append_data(out, context.id, false, true, identifier, longest_pdu_);
    return send(out);
}

Result<std::uint16_t> Requestor::find(const PresentationContext& context, std::string_view identifier,
                                      const Matched& matched) {
    Command request;
    request.field = dimse::find_request;
    ANATOMESH_CHECK_STATUS(send_request(context, request, identifier));
    Inbox inbox;
    bool is_cancelled = false;
    while (true) {
        ANATOMESH_CHECK_STATUS(receive_message(inbox));
        const std::uint16_t status = inbox.message.status;
        if (inbox.message.field != dimse::find_reply) return lost("the peer does not keep to the protocol");
        if (status != dimse::pending && status != dimse::pending_with_warning) return status;
        ANATOMESH_CHECK_STATUS(budget_.spend_answer());
        if (is_cancelled || matched(inbox.data_set)) continue;
        is_cancelled = true;
        Command cancel;
        cancel.field = dimse::cancel_request;
        cancel.replied_to = request.message;
        ANATOMESH_CHECK_STATUS(send_command(context.id, cancel));
    }
}

Result<std::uint16_t> Requestor::retrieve(const PresentationContext& context, Command request,
                                          std::string_view identifier, const OpenSink& open,
                                          RetrieveCounts& counts, const Progress& progress) {
    ANATOMESH_CHECK_STATUS(send_request(context, request, identifier));
    Inbox inbox(open);
    inbox.find_context = [this](std::uint8_t id) -> const PresentationContext* {
        for (const PresentationContext& each : accepted_)
            if (each.id == id) return &each;
        return nullptr;
    };
    while (true) {
        ANATOMESH_CHECK_STATUS(receive_message(inbox));
        ANATOMESH_CHECK_STATUS(budget_.spend_answer());
        const Command& got = inbox.message;
        if (got.field == dimse::store_request) {
            Command reply;
            reply.field = dimse::store_reply;
            reply.replied_to = got.message;
            reply.status = inbox.store_status;
            reply.sop_class = got.sop_class.substr(0, longest_uid);
            reply.sop_instance = got.sop_instance.substr(0, longest_uid);
            ANATOMESH_CHECK_STATUS(send_command(inbox.context, reply));
            continue;
        }
        if (got.field != (request.field | 0x8000)) return lost("the peer does not keep to the protocol");
        counts = {got.completed, got.failed, got.warned};
        if (progress) progress(got);
        if (got.status != dimse::pending && got.status != dimse::pending_with_warning) return got.status;
    }
}

Result<std::uint16_t> Requestor::get(const PresentationContext& context, std::string_view identifier,
                                     const OpenSink& open, RetrieveCounts& counts, const Progress& progress) {
    Command request;
    request.field = dimse::get_request;
    return retrieve(context, request, identifier, open, counts, progress);
}

Result<std::uint16_t> Requestor::move(const PresentationContext& context, std::string_view identifier,
                                      const std::string& destination, RetrieveCounts& counts,
                                      const Progress& progress) {
    Command request;
    request.field = dimse::move_request;
    request.move_destination = destination;
    return retrieve(context, request, identifier, {}, counts, progress);
}

void Requestor::release() {
    RequestLimits ending = options_.limits;
    ending.seconds = std::min(options_.timeout_seconds, release_seconds);
    ending.begun = Clock::now();
    budget_ = RequestBudget(ending, name_of(options_.peer));
    if (!send(format_release(PduType::release_request)).ok()) return;
    PduType type = PduType::abort;
    std::string body;
    while (receive_pdu(type, body).ok() && type != PduType::release_reply) {
    }
}

}  // namespace anatomesh
