// The protocol data units (PDUs) of the DICOM upper layer as bytes in and out. Opens no socket.
//
// Every length is checked against the bytes that are there; nothing is allocated by a length that the peer
// claims. Follows: DICOM PS3.8, chapter 9 and annex D.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anatomesh {

enum class PduType : std::uint8_t {
    associate_request = 1,
    associate_accept = 2,
    associate_reject = 3,
    data = 4,
    release_request = 5,
    release_reply = 6,
    abort = 7
};

// A PDU begins with its type, a reserved byte and its length. [bytes; 6; D DICOM PS3.8, section 9.3]
inline constexpr std::size_t pdu_header_bytes = 6;
// This side takes no longer body of a PDU, and says so when it associates. [bytes; >= 4096; B]
inline constexpr std::uint32_t longest_pdu_body = 131072;
// A UID has no more characters. [bytes; 64; D DICOM PS3.5, section 9]
inline constexpr std::size_t longest_uid = 64;
// An application entity's title has no more characters. [bytes; 16; D DICOM PS3.5, section 6.2]
inline constexpr std::size_t longest_ae_title = 16;
// An association has no more contexts, because their ids are odd bytes.
// [contexts; 128; D DICOM PS3.8, section 9.3]
inline constexpr std::size_t most_presentation_contexts = 128;
inline constexpr std::string_view application_context_name = "1.2.840.10008.3.1.1.1";  // PS3.7, annex A
// Of this program, in what it sends and stores; a UID made from a UUID (PS3.5, annex B.2).
inline constexpr std::string_view implementation_class_uid = "2.25.231180546138466129170253893712506374981";

// What a peer offers to talk about: an abstract syntax (SOP class) and how its data sets would be encoded.
struct PresentationContext {
    std::uint8_t id = 0;  // odd
    std::string abstract_syntax;
    std::vector<std::string> transfer_syntaxes;  // one in an answer
    std::uint8_t result = 0;  // in an answer: 0 accepted, 3 abstract syntax, 4 no transfer syntax supported
};
// The peer accepts the context. [code; 0; D DICOM PS3.8, section 9.3]
inline constexpr std::uint8_t context_accepted = 0;
// The peer does not know the SOP class. [code; 3; D DICOM PS3.8, section 9.3]
inline constexpr std::uint8_t context_no_abstract_syntax = 3;
// The peer knows none of the encodings. [code; 4; D DICOM PS3.8, section 9.3]
inline constexpr std::uint8_t context_no_transfer_syntax = 4;

// Who is client and server for a SOP class, where that is not the usual way round (C-GET).
struct RoleSelection {
    std::string sop_class;
    bool is_client = false, is_server = false;
};

// The content of an A-ASSOCIATE-RQ or -AC.
struct Association {
    std::uint16_t protocol_version = 1;
    std::string called, calling;  // AE titles without blanks at their ends
    std::string application_context;
    std::vector<PresentationContext> contexts;
    std::vector<RoleSelection> roles;
    std::uint32_t longest_pdu = 0;  // body that the sender of this takes; 0: any
};

// Why an association is rejected: PS3.8 table 9-21.
struct Rejection {
    std::uint8_t result = 1;  // 1 permanent, 2 transient
    std::uint8_t source = 1;  // 1 user, 2 provider (ACSE), 3 provider (presentation)
    std::uint8_t reason = 1;
    friend bool operator==(const Rejection&, const Rejection&) = default;
};
inline constexpr Rejection rejected_no_reason{1, 1, 1}, rejected_application_context{1, 1, 2},
    rejected_calling{1, 1, 3}, rejected_called{1, 1, 7}, rejected_protocol{1, 2, 2}, rejected_limit{2, 3, 2};
std::string text_of(const Rejection& rejection);

// Why this side aborts (source 2, provider): PS3.8 table 9-26.
enum class AbortReason : std::uint8_t {
    not_specified = 0,
    unrecognized_pdu = 1,
    unexpected_pdu = 2,
    invalid_parameter = 6
};

struct PduHeader {
    std::uint8_t type = 0;
    std::uint32_t length = 0;  // of the body
};
// Requires: at least pdu_header_bytes.
PduHeader parse_pdu_header(std::string_view bytes);

// Whole PDUs.
std::string format_associate(PduType type, const Association& association);
std::string format_reject(const Rejection& rejection);
std::string format_abort(AbortReason reason);
std::string format_release(PduType type);

// Bodies. Nothing: malformed (lengths that do not fit, an even, zero or repeated context id, more than 128
// contexts, a context of a request without an abstract syntax).
std::optional<Association> parse_associate(PduType type, std::string_view body);
std::optional<Rejection> parse_reject(std::string_view body);

// A fragment of a command or of a data set.
struct DataFragment {
    std::uint8_t context = 0;
    bool is_command = false, is_last = false;
    std::string_view bytes;
};
// The fragments of a P-DATA-TF body, views into it. Nothing: malformed (none, lengths that do not fit).
std::optional<std::vector<DataFragment>> parse_data(std::string_view body);
// Appends `bytes` as P-DATA-TF PDUs whose bodies are no longer than `longest_pdu` (0: any); the last fragment
// is marked so when `is_last`. Requires: longest_pdu is 0 or above 6.
void append_data(std::string& out, std::uint8_t context, bool is_command, bool is_last,
                 std::string_view bytes, std::uint32_t longest_pdu);

// "1.2.840...": digits and points, 1 to 64 of them, no component empty.
bool is_uid(std::string_view text);
// An AE title: 1 to 16 printable ASCII characters without backslash, not all blank.
bool is_ae_title(std::string_view text);

}  // namespace anatomesh
