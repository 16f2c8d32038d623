// Acceptor: one association as the accepting side sees it: bytes of the peer in, bytes for the peer out.
// Opens no socket and knows no time. Serves C-ECHO and C-STORE.
//
// Follows the state table of PS3.8 section 9.2 for a service provider: states 2 (waiting for a request), 6
// (associated) and 13 (waiting for the peer to close).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "anatomesh_io/network/dimse.h"
#include "anatomesh_io/network/pdu.h"

namespace anatomesh {

// What a C-STORE request says of its object.
struct ObjectLabel {
    std::string sop_class, sop_instance, transfer_syntax;
};

// Takes one object. What is not finished is discarded with it.
class ObjectSink {
  public:
    virtual ~ObjectSink() = default;
    virtual void write(std::string_view bytes) = 0;
    virtual std::uint16_t finish() = 0;  // the status of the C-STORE
};

class Acceptor : private MessageAssembler::Sink {
  public:
    struct Rules {
        // Whether the peer may associate; nothing: yes. Asked once.
        std::function<std::optional<Rejection>(const Association&)> admit;
        std::function<std::unique_ptr<ObjectSink>(const ObjectLabel&)> store;
        // How the state ended an association that did not end as it should: for the log.
        std::function<void(const std::string&)> complain;
    };
    enum class State : std::uint8_t {
        waiting,  // for the request
        associated,
        parting,  // nothing more is said; the peer closes
        over      // close once the output is sent
    };

    // `rules` must outlive it.
    explicit Acceptor(const Rules& rules) : rules_(&rules) {}

    // Takes what the peer has sent. Keeps less than one PDU of it.
    void receive(std::string_view bytes);
    // Aborts, because time is up or the program ends.
    void abort(AbortReason reason);

    State state() const { return state_; }
    const Association& association() const { return association_; }
    // Whether a message has begun that has not come to its end.
    bool is_within_message() const { return assembler_.is_within_message(); }
    std::string& output() { return output_; }

  private:
    void take(std::uint8_t type, std::string_view body);
    void take_request(std::string_view body);
    void take_data(std::string_view body);
    void command(std::uint8_t context, const Command& command) override;
    void data(std::string_view bytes) override;
    void end_of_data() override;
    void begin_store(std::uint8_t context, const Command& command);
    void reply(std::uint16_t status);
    void refuse(AbortReason reason, const std::string& why);

    const Rules* rules_;
    State state_ = State::waiting;
    Association association_;  // as asked for; the contexts as answered
    MessageAssembler assembler_;
    std::string input_, output_;
    Command request_;            // being served
    std::uint8_t context_ = 0;   // of it
    std::uint16_t failure_ = 0;  // of a request whose data set is passed over
    std::unique_ptr<ObjectSink> sink_;
};

// The answers to the contexts of a request: storage of all classes of the standard, and verification. Of
// several transfer syntaxes explicit VR little endian is taken, but implicit for contours: their lists may be
// longer than a length of 16 bits says.
std::vector<PresentationContext> answer_contexts(const std::vector<PresentationContext>& asked);

// Whether objects of the class can be stored: the storage classes that DCMTK lists.
bool is_storage_class(std::string_view sop_class);
// Whether data sets of the syntax are read by this program (not deflated ones, not video).
bool is_readable_syntax(std::string_view transfer_syntax);
// Those of them that compress pixels.
std::vector<std::string> compressed_syntaxes();

}  // namespace anatomesh
