#include "anatomesh_io/network/dimse.h"

#include "anatomesh_io/contour/dicom_text.h"

namespace anatomesh {

namespace {

// A longer command is refused: those of the standard are shorter by far. [bytes; >= 1024; B]
constexpr std::size_t longest_command = 65536;
// This Command Data Set Type says that no data set follows. [code; 0x0101; D DICOM PS3.7, annex E]
constexpr std::uint16_t no_data_set = 0x0101;

// Element numbers in group 0.
enum Element : std::uint16_t {
    group_length = 0x0000,
    affected_class = 0x0002,
    requested_class = 0x0003,
    command_field = 0x0100,
    message_id = 0x0110,
    replied_id = 0x0120,
    destination = 0x0600,
    priority_element = 0x0700,
    data_set_type = 0x0800,
    status_element = 0x0900,
    affected_instance = 0x1000,
    requested_instance = 0x1001,
    remaining_count = 0x1020,
    completed_count = 0x1021,
    failed_count = 0x1022,
    warned_count = 0x1023
};

void append_number(std::string& out, std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i));
}
void append_dimse_short(std::string& out, Element element, std::uint16_t value) {
    append_number(out, 0, 2);
    append_number(out, element, 2);
    append_number(out, 2, 4);
    append_number(out, value, 2);
}
void append_text(std::string& out, Element element, std::string_view text, char pad) {
    if (text.empty()) return;
    append_number(out, 0, 2);
    append_number(out, element, 2);
    append_number(out, text.size() + text.size() % 2, 4);
    out += text;
    if (text.size() % 2 != 0) out += pad;
}

std::uint64_t number_at(std::string_view bytes, std::size_t at, int size) {
    std::uint64_t value = 0;
    for (int i = size; i-- > 0;)
        value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
    return value;
}

std::uint16_t* short_field(Command& command, std::uint16_t element) {
    switch (element) {
        case command_field:
            return &command.field;
        case message_id:
            return &command.message;
        case replied_id:
            return &command.replied_to;
        case priority_element:
            return &command.priority;
        case status_element:
            return &command.status;
        case remaining_count:
            return &command.remaining;
        case completed_count:
            return &command.completed;
        case failed_count:
            return &command.failed;
        case warned_count:
            return &command.warned;
        default:
            return nullptr;
    }
}

std::string* text_field(Command& command, std::uint16_t element) {
    switch (element) {
        case affected_class:
        case requested_class:
            return &command.sop_class;
        case affected_instance:
        case requested_instance:
            return &command.sop_instance;
        case destination:
            return &command.move_destination;
        default:
            return nullptr;
    }
}

}  // namespace

std::string format_command(const Command& command) {
    std::string body;
    append_text(body, affected_class, command.sop_class, '\0');
    append_dimse_short(body, command_field, command.field);
    const bool names_message = command.is_reply() || command.field == dimse::cancel_request;
    if (!names_message) append_dimse_short(body, message_id, command.message);
    if (names_message) append_dimse_short(body, replied_id, command.replied_to);
    append_text(body, destination, command.move_destination, ' ');
    const bool has_priority = command.field == dimse::store_request || command.field == dimse::find_request ||
                              command.field == dimse::get_request || command.field == dimse::move_request;
    if (has_priority) append_dimse_short(body, priority_element, command.priority);
    append_dimse_short(body, data_set_type, command.has_data_set ? 0 : no_data_set);
    if (command.is_reply()) append_dimse_short(body, status_element, command.status);
    append_text(body, affected_instance, command.sop_instance, '\0');
    std::string out;
    append_number(out, 0, 2);
    append_number(out, group_length, 2);
    append_number(out, 4, 4);
    append_number(out, body.size(), 4);
    return out + body;
}

std::optional<Command> parse_command(std::string_view bytes) {
    Command command;
    bool has_field = false, has_type = false, has_status = false;
    while (!bytes.empty()) {
        if (bytes.size() < 8) return std::nullopt;
        // Archives put what failed (group 8) into the command itself.
        const bool is_ours = number_at(bytes, 0, 2) == 0;
        const auto element = static_cast<std::uint16_t>(number_at(bytes, 2, 2));
        const std::uint64_t length = number_at(bytes, 4, 4);
        if (length > bytes.size() - 8) return std::nullopt;
        const std::string_view value = bytes.substr(8, length);
        bytes.remove_prefix(8 + length);
        if (!is_ours) continue;
        if (element == data_set_type) {
            if (length != 2) return std::nullopt;
            command.has_data_set = number_at(value, 0, 2) != no_data_set;
            has_type = true;
        } else if (std::uint16_t* number = short_field(command, element)) {
            if (length != 2) return std::nullopt;
            *number = static_cast<std::uint16_t>(number_at(value, 0, 2));
            has_field = has_field || element == command_field;
            has_status = has_status || element == status_element;
        } else if (std::string* text = text_field(command, element)) {
            *text = without_padding(value);
        }
    }
    if (!has_field || !has_type || (command.is_reply() && !has_status)) return std::nullopt;
    return command;
}

bool MessageAssembler::feed(const DataFragment& fragment, Sink& sink) {
    if (is_within_message() && fragment.context != context_) return false;
    if (within_data_) {
        if (fragment.is_command) return false;
        sink.data(fragment.bytes);
        if (fragment.is_last) {
            within_data_ = false;
            sink.end_of_data();
        }
        return true;
    }
    if (!fragment.is_command || fragment.bytes.size() > longest_command - command_.size()) return false;
    context_ = fragment.context;
    command_ += fragment.bytes;
    if (!fragment.is_last) return true;
    const std::optional<Command> command = parse_command(command_);
    command_.clear();
    if (!command) return false;
    within_data_ = command->has_data_set;
    sink.command(context_, *command);
    return true;
}

}  // namespace anatomesh
