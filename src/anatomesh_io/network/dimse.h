// DIMSE: the commands that DICOM peers exchange over an association, and the assembly of messages from
// fragments. Opens no socket. Follows: DICOM PS3.7, chapters 9 and E; PS3.8 annex E.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "anatomesh_io/network/pdu.h"

namespace anatomesh {

namespace dimse {
// This Command Field asks to store an object. [code; 0x0001; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t store_request = 0x0001;
// This Command Field answers a C-STORE. [code; 0x8001; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t store_reply = 0x8001;
// This Command Field asks to send objects back on the same association.
// [code; 0x0010; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t get_request = 0x0010;
// This Command Field answers a C-GET. [code; 0x8010; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t get_reply = 0x8010;
// This Command Field asks which objects there are. [code; 0x0020; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t find_request = 0x0020;
// This Command Field answers a C-FIND. [code; 0x8020; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t find_reply = 0x8020;
// This Command Field asks to send objects to a third. [code; 0x0021; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t move_request = 0x0021;
// This Command Field answers a C-MOVE. [code; 0x8021; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t move_reply = 0x8021;
// This Command Field asks whether anybody is there. [code; 0x0030; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t echo_request = 0x0030;
// This Command Field answers a C-ECHO. [code; 0x8030; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t echo_reply = 0x8030;
// This Command Field ends a request that is being answered. [code; 0x0FFF; D DICOM PS3.7, annex E]
inline constexpr std::uint16_t cancel_request = 0x0FFF;
// This status says that the operation is done. [code; 0x0000; D DICOM PS3.7, annex C]
inline constexpr std::uint16_t success = 0x0000;
// This status says that further answers follow. [code; 0xFF00; D DICOM PS3.4, section C.4]
inline constexpr std::uint16_t pending = 0xFF00;
// This status says so too, where a key of the query was not heeded.
// [code; 0xFF01; D DICOM PS3.4, section C.4]
inline constexpr std::uint16_t pending_with_warning = 0xFF01;
// This status says that the peer may not do this. [code; 0x0124; D DICOM PS3.7, annex C]
inline constexpr std::uint16_t not_authorized = 0x0124;
// This status says that the operation is not known. [code; 0x0211; D DICOM PS3.7, annex C]
inline constexpr std::uint16_t no_such_operation = 0x0211;
// This status says that there is no room for the object. [code; 0xA700; D DICOM PS3.4, section B.2.3]
inline constexpr std::uint16_t out_of_resources = 0xA700;
// This status says that the object is not of the class that it was announced with.
// [code; 0xA900; D DICOM PS3.4, section B.2.3]
inline constexpr std::uint16_t does_not_match_class = 0xA900;
// This status says that the object is damaged. [code; 0xC000; D DICOM PS3.4, section B.2.3]
inline constexpr std::uint16_t cannot_understand = 0xC000;
// This status of our own says that an object with the same UID and other content is there.
// [code; 0xC000 to 0xCFFF; D]
inline constexpr std::uint16_t other_content = 0xC111;
// This status of our own says that something with the same UID is there that cannot be read and compared.
// [code; 0xC000 to 0xCFFF; D]
inline constexpr std::uint16_t unreadable_there = 0xC112;
// This status says that the operation was cancelled. [code; 0xFE00; D DICOM PS3.7, annex C]
inline constexpr std::uint16_t cancelled = 0xFE00;
}  // namespace dimse

// SOP classes and transfer syntaxes.
inline constexpr const char* verification_class = "1.2.840.10008.1.1";
inline constexpr const char* implicit_little_syntax = "1.2.840.10008.1.2";
inline constexpr const char* explicit_little_syntax = "1.2.840.10008.1.2.1";
inline constexpr const char* explicit_big_syntax = "1.2.840.10008.1.2.2";
inline constexpr const char* rtstruct_class = "1.2.840.10008.5.1.4.1.1.481.3";
inline constexpr const char* segmentation_class = "1.2.840.10008.5.1.4.1.1.66.4";

// Fields that a command does not have are empty or zero.
struct Command {
    std::uint16_t field = 0;
    std::uint16_t message = 0;     // id of this request
    std::uint16_t replied_to = 0;  // id of the request that this replies to
    std::uint16_t status = 0;
    std::uint16_t priority = 0;
    bool has_data_set = false;
    std::string sop_class, sop_instance;  // affected or requested
    std::string move_destination;
    std::uint16_t remaining = 0, completed = 0, failed = 0, warned = 0;  // sub-operations

    bool is_reply() const { return (field & 0x8000) != 0; }
};

// The command set, implicit VR little endian, with its group length.
std::string format_command(const Command& command);
// Nothing: lengths that do not fit, values of a wrong size, no command field, no word on a data set, or a reply
// without its status, which would look like success.
std::optional<Command> parse_command(std::string_view bytes);

// Puts fragments together: a command, then its data set when it has one. The data set is handed on as it
// comes; only commands are kept, up to 64 KiB.
class MessageAssembler {
  public:
    class Sink {
      public:
        virtual ~Sink() = default;
        virtual void command(std::uint8_t context, const Command& command) = 0;
        virtual void data(std::string_view bytes) = 0;
        virtual void end_of_data() = 0;
    };

    // False: the fragment is out of place (another context or a command within a message, a data set nobody
    // announced) or the command is malformed; nothing more may be fed then.
    bool feed(const DataFragment& fragment, Sink& sink);
    // Whether a message has begun and not ended.
    bool is_within_message() const { return within_data_ || !command_.empty(); }

  private:
    std::string command_;
    std::uint8_t context_ = 0;
    bool within_data_ = false;
};

}  // namespace anatomesh
