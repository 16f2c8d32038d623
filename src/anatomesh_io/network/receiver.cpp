#include "anatomesh_io/network/receiver.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace anatomesh {

namespace {

// So many connections without an association are kept; beyond it the oldest goes. [connections; >= 1; B]
constexpr std::size_t most_silent = 64;
// A peer that leaves so much unread is no longer listened to until it reads. [bytes; >= 1024; B]
constexpr std::size_t most_output = 65536;
// The log counts the lines of so many peers; beyond it all counts begin again. [peers; >= 1; B]
constexpr std::size_t most_logging_peers = 1000;
// The log takes no more lines of a peer in a minute, so that none fills the disk. [lines; >= 1; B]
constexpr int lines_a_minute = 10;
// The receiver looks at its clocks and at the wish to stop at least as often. [ms; > 0; B]
constexpr int poll_milliseconds = 100;

double seconds_since(Clock::time_point then, Clock::time_point now) {
    return std::chrono::duration<double>(now - then).count();
}

// Lets through so many lines a minute of each peer, and says how many it kept back.
class RateLimitedLog {
  public:
    explicit RateLimitedLog(const std::function<void(const std::string&)>& out) : out_(out) {}

    void line(const std::string& peer, const std::string& text, Clock::time_point now) {
        if (peers_.size() >= most_logging_peers && !peers_.contains(peer)) peers_.clear();
        Peer& state = peers_[peer];
        if (state.lines == 0 || seconds_since(state.since, now) >= 60) {
            if (state.kept_back > 0) out_(peer + ": " + std::to_string(state.kept_back) + " lines not shown");
            state = {now, 0, 0};
        }
        if (++state.lines <= lines_a_minute)
            out_(peer + ": " + text);
        else
            ++state.kept_back;
    }

  private:
    struct Peer {
        Clock::time_point since;
        int lines = 0, kept_back = 0;
    };
    const std::function<void(const std::string&)>& out_;
    std::map<std::string, Peer> peers_;
};

std::string hexadecimal(std::uint16_t value) {
    constexpr char digits[] = "0123456789ABCDEF";
    std::string text = "0x";
    for (int shift = 12; shift >= 0; shift -= 4) text += digits[value >> shift & 15];
    return text;
}

class Receiver;

// One peer.
struct Connection {
    Connection(Receiver& receiver, Stream socket, std::string address);

    Acceptor::Rules rules;
    Stream stream;
    std::string peer;
    Acceptor acceptor;
    Clock::time_point begun, active, associated, parted;
    Acceptor::State seen = Acceptor::State::waiting;
    std::uint64_t bytes = 0;
    std::size_t stored = 0;
    std::set<std::string> studies;  // that objects of this association were stored in
    bool is_over = false, is_shut = false, has_complained = false;
    short wanted = POLLIN;

    bool is_silent() const { return acceptor.state() != Acceptor::State::associated; }
};

class Receiver {
  public:
    Receiver(ObjectStore& store, const ReceiverOptions& options, const ReceiverHooks& hooks, int listener)
        : store_(store), options_(options), hooks_(hooks), listener_(listener), log_(hooks.log) {}

    void step();
    bool tick();
    void end();

    std::optional<Rejection> admit(const Connection& connection, const Association& asked);
    std::unique_ptr<ObjectSink> sink(Connection& connection, const ObjectLabel& label);
    void complain(Connection& connection, const std::string& what);
    void object_ended(Connection& connection, const StoreOutcome& outcome);

    const ReceiverSummary& summary() const { return summary_; }

  private:
    void accept_new();
    void make_room();
    void read_from(Connection& connection);
    void write_to(Connection& connection);
    void note_state(Connection& connection);
    void check_time(Connection& connection);

    ObjectStore& store_;
    const ReceiverOptions& options_;
    const ReceiverHooks& hooks_;
    int listener_;
    RateLimitedLog log_;
    std::vector<std::unique_ptr<Connection>> connections_;
    ReceiverSummary summary_;
    Clock::time_point now_ = Clock::now();
    std::vector<char> buffer_ = std::vector<char>(std::size_t{1} << 18);
};

Connection::Connection(Receiver& receiver, Stream socket, std::string address)
    : rules{[&receiver, this](const Association& asked) { return receiver.admit(*this, asked); },
            [&receiver, this](const ObjectLabel& label) { return receiver.sink(*this, label); },
            [&receiver, this](const std::string& what) { receiver.complain(*this, what); }},
      stream(std::move(socket)),
      peer(std::move(address)),
      acceptor(rules),
      begun(Clock::now()),
      active(begun),
      associated(begun),
      parted(begun) {}

class StoreSink : public ObjectSink {
  public:
    StoreSink(Receiver& receiver, Connection& connection, ObjectStore& store, const ObjectLabel& label)
        : receiver_(receiver), connection_(connection), incoming_(store, label) {
        incoming_.begin_data_set();
    }
    void write(std::string_view bytes) override { incoming_.write(bytes); }
    std::uint16_t finish() override {
        const StoreOutcome outcome = incoming_.finish();
        receiver_.object_ended(connection_, outcome);
        return outcome.status;
    }

  private:
    Receiver& receiver_;
    Connection& connection_;
    ObjectStore::Incoming incoming_;
};

std::unique_ptr<ObjectSink> Receiver::sink(Connection& connection, const ObjectLabel& label) {
    return std::make_unique<StoreSink>(*this, connection, store_, label);
}

std::optional<Rejection> Receiver::admit(const Connection& connection, const Association& asked) {
    bool host_is_known = false, title_is_known = false;
    if (options_.allowed.empty()) host_is_known = title_is_known = is_loopback(connection.peer);
    for (const AllowedPeer& allowed : options_.allowed) {
        const auto& hosts = allowed.addresses;
        if (!hosts.empty() && std::find(hosts.begin(), hosts.end(), connection.peer) == hosts.end()) continue;
        host_is_known = true;
        title_is_known = title_is_known || allowed.title.empty() || allowed.title == asked.calling;
    }
    const auto associated = static_cast<std::size_t>(std::count_if(
        connections_.begin(), connections_.end(), [](const auto& each) { return !each->is_silent(); }));
    std::optional<Rejection> rejection;
    if (!host_is_known)
        rejection = rejected_no_reason;
    else if (asked.called != options_.title)
        rejection = rejected_called;
    else if (!title_is_known || !is_ae_title(asked.calling))
        rejection = rejected_calling;
    else if (associated >= options_.associations)
        rejection = rejected_limit;
    if (rejection) {
        ++summary_.rejected;
        log_.line(connection.peer,
                  !host_is_known ? "rejected: the host is not allowed" : "rejected: " + text_of(*rejection),
                  now_);
    }
    return rejection;
}

void Receiver::complain(Connection& connection, const std::string& what) {
    if (connection.has_complained || what.empty()) return;
    connection.has_complained = true;
    log_.line(connection.peer, "aborted: " + what, now_);
}

void Receiver::object_ended(Connection& connection, const StoreOutcome& outcome) {
    switch (outcome.end) {
        case StoreEnd::stored:
            ++summary_.stored;
            summary_.bytes += outcome.bytes;
            ++connection.stored;
            break;
        case StoreEnd::there_already:
            ++summary_.there_already;
            break;
        case StoreEnd::refused:
        case StoreEnd::unasked:
            ++summary_.refused;
            log_.line(connection.peer,
                      "object refused with " + hexadecimal(outcome.status) + ": " + outcome.reason, now_);
            break;
    }
    if (outcome.end == StoreEnd::stored || outcome.end == StoreEnd::there_already)
        connection.studies.insert(outcome.path.substr(0, outcome.path.find('/')));
    hooks_.ended(outcome);
}

// The oldest connection without an association goes.
void Receiver::make_room() {
    const auto is_older = [](const auto& a, const auto& b) {
        return a->is_silent() != b->is_silent() ? a->is_silent() : a->begun < b->begun;
    };
    const auto oldest = std::min_element(connections_.begin(), connections_.end(), is_older);
    if (oldest != connections_.end() && (*oldest)->is_silent()) connections_.erase(oldest);
}

void Receiver::accept_new() {
    for (std::size_t i = 0; i < most_silent; ++i) {
        std::string peer;
        const int descriptor = accept_from(listener_, peer);
        if (descriptor < 0) {
            // Out of descriptors: room for the next.
            if (errno == EMFILE || errno == ENFILE) make_room();
            return;
        }
        while (connections_.size() >= options_.associations + most_silent) {
            const std::size_t before = connections_.size();
            make_room();
            assert(connections_.size() < before);
            if (connections_.size() == before) break;
        }
        Stream stream = options_.tls ? Stream(descriptor, *options_.tls, true, {}) : Stream(descriptor);
        connections_.push_back(std::make_unique<Connection>(*this, std::move(stream), std::move(peer)));
    }
}

void Receiver::read_from(Connection& connection) {
    std::size_t got = 0;
    const StreamState state = connection.stream.read(buffer_.data(), buffer_.size(), got);
    if (state == StreamState::wants_write) connection.wanted |= POLLOUT;
    if (state == StreamState::closed || state == StreamState::failed) {
        if (!connection.is_silent())
            complain(connection, "the peer went away");
        else if (state == StreamState::failed && options_.tls)
            complain(connection, "no TLS: " + connection.stream.reason());
        connection.is_over = true;
    }
    if (state != StreamState::done) return;
    connection.active = now_;
    connection.bytes += got;
    connection.acceptor.receive({buffer_.data(), got});
}

void Receiver::write_to(Connection& connection) {
    std::string& output = connection.acceptor.output();
    std::size_t sent = 0;
    while (sent < output.size() && !connection.is_over) {
        std::size_t put = 0;
        const StreamState state = connection.stream.write(std::string_view(output).substr(sent), put);
        if (state == StreamState::closed || state == StreamState::failed) connection.is_over = true;
        if (state == StreamState::wants_write) connection.wanted |= POLLOUT;
        if (state != StreamState::done) break;
        sent += put;
        connection.active = now_;
    }
    output.erase(0, sent);
}

void Receiver::note_state(Connection& connection) {
    using State = Acceptor::State;
    const State state = connection.acceptor.state();
    const bool all_sent = connection.acceptor.output().empty();
    if (state == State::over && all_sent) connection.is_over = true;
    // What is unread when a socket closes destroys what was sent: the peer closes first, or time does.
    if (state == State::parting && all_sent && !connection.is_shut) {
        connection.stream.shut_down();
        connection.is_shut = true;
    }
    if (state == connection.seen) return;
    connection.seen = state;
    connection.parted = now_;
    if (state == State::associated) {
        ++summary_.associations;
        connection.associated = now_;
        connection.bytes = 0;
    } else if (connection.stored > 0) {
        log_.line(connection.peer, std::to_string(connection.stored) + " objects stored", now_);
        connection.stored = 0;
    }
}

void Receiver::check_time(Connection& connection) {
    const auto give_up = [&](const std::string& why) {
        complain(connection, why);
        connection.acceptor.abort(AbortReason::not_specified);
        write_to(connection);
        connection.is_over = true;
    };
    switch (connection.acceptor.state()) {
        case Acceptor::State::waiting:
            if (seconds_since(connection.begun, now_) > options_.timeout_seconds)
                give_up("it did not associate in time");
            return;
        case Acceptor::State::associated: {
            const double age = seconds_since(connection.associated, now_);
            if (seconds_since(connection.active, now_) > options_.timeout_seconds)
                give_up("it was silent for too long");
            else if (age > options_.association_seconds &&
                     static_cast<double>(connection.bytes) < age * options_.least_rate)
                give_up("it is too slow");
            return;
        }
        case Acceptor::State::parting:
        case Acceptor::State::over:
            if (seconds_since(connection.parted, now_) > options_.timeout_seconds) connection.is_over = true;
            return;
    }
}

void Receiver::step() {
    std::vector<pollfd> sockets{{listener_, POLLIN, 0}};
    for (const auto& each : connections_) sockets.push_back({each->stream.descriptor(), each->wanted, 0});
    ::poll(sockets.data(), sockets.size(), poll_milliseconds);
    now_ = Clock::now();
    for (std::size_t i = 0; i < connections_.size(); ++i) {
        Connection& connection = *connections_[i];
        const short ready = sockets[i + 1].revents;
        connection.wanted = 0;
        const bool listens = connection.acceptor.output().size() < most_output;
        if (ready != 0 && listens) read_from(connection);
        if (ready != 0 || !connection.acceptor.output().empty()) write_to(connection);
        note_state(connection);
        check_time(connection);
        if (connection.acceptor.output().size() < most_output) connection.wanted |= POLLIN;
    }
    std::erase_if(connections_, [](const auto& each) { return each->is_over; });
    if (sockets[0].revents != 0) accept_new();
}

bool Receiver::tick() {
    std::set<std::string> studies;
    for (const auto& each : connections_)
        if (!each->is_silent()) studies.insert(each->studies.begin(), each->studies.end());
    return hooks_.tick && hooks_.tick({studies.begin(), studies.end()});
}

void Receiver::end() {
    now_ = Clock::now();
    for (const auto& each : connections_) {
        each->acceptor.abort(AbortReason::not_specified);
        write_to(*each);
        note_state(*each);
    }
    connections_.clear();
}

}  // namespace

Result<ReceiverSummary> receive_objects(ObjectStore& store, const ReceiverOptions& options,
                                        const ReceiverHooks& hooks, const RunContext& context) {
    assert(options.associations >= 1 && options.timeout_seconds > 0);
    ANATOMESH_TRY(const Listener listener, listen_at(options.address, options.port));
    if (hooks.listening) hooks.listening(listener.port);
    Receiver receiver(store, options, hooks, listener.descriptor);
    while (!context.cancelled()) {
        receiver.step();
        if (receiver.tick()) break;
    }
    receiver.end();
    ::close(listener.descriptor);
    return receiver.summary();
}

}  // namespace anatomesh
