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
inline constexpr std::uint16_t store_request = 0x0001, store_reply = 0x8001, get_request = 0x0010,
                               get_reply = 0x8010, find_request = 0x0020, find_reply = 0x8020,
                               move_request = 0x0021, move_reply = 0x8021, echo_request = 0x0030,
                               echo_reply = 0x8030, cancel_request = 0x0FFF;
// Status codes.
inline constexpr std::uint16_t success = 0x0000, pending = 0xFF00, pending_with_warning = 0xFF01,
                               no_such_operation = 0x0211, out_of_resources = 0xA700,
                               does_not_match_class = 0xA900, cannot_understand = 0xC000,
                               other_content = 0xC111, cancelled = 0xFE00;
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
// Nothing: lengths that do not fit, values of a wrong size, no command field, or no word on a data set.
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
