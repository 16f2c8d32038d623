#include "anatomesh_io/network/pdu.h"

#include <algorithm>
#include <bitset>
#include <cassert>

#include "anatomesh_io/contour/dicom_text.h"

namespace anatomesh {

namespace {

constexpr std::string_view implementation_version = "ANATOMESH";
// The body of an A-ASSOCIATE begins with fields of this size in all; items follow.
// [bytes; 68; D DICOM PS3.8, section 9.3]
constexpr std::size_t fixed_associate_bytes = 68;

enum Item : std::uint8_t {
    application_item = 0x10,
    request_context_item = 0x20,
    accept_context_item = 0x21,
    abstract_item = 0x30,
    transfer_item = 0x40,
    user_item = 0x50,
    longest_item = 0x51,
    class_item = 0x52,
    role_item = 0x54,
    version_item = 0x55
};

std::uint8_t byte_at(std::string_view bytes, std::size_t at) {
    return static_cast<std::uint8_t>(bytes[at]);
}
std::uint16_t short_at(std::string_view bytes, std::size_t at) {
    return static_cast<std::uint16_t>(byte_at(bytes, at) << 8 | byte_at(bytes, at + 1));
}
std::uint32_t long_at(std::string_view bytes, std::size_t at) {
    return std::uint32_t{short_at(bytes, at)} << 16 | short_at(bytes, at + 2);
}

void append_short(std::string& out, std::size_t value) {
    assert(value <= 0xFFFF);
    out += static_cast<char>(value >> 8);
    out += static_cast<char>(value & 0xFF);
}
void append_long(std::string& out, std::uint32_t value) {
    append_short(out, value >> 16);
    append_short(out, value & 0xFFFF);
}
void append_item(std::string& out, Item type, std::string_view content) {
    out += static_cast<char>(type);
    out += '\0';
    append_short(out, content.size());
    out += content;
}
std::string pdu(PduType type, std::string_view body) {
    std::string out;
    out += static_cast<char>(type);
    out += '\0';
    append_long(out, static_cast<std::uint32_t>(body.size()));
    out += body;
    return out;
}

std::string padded_title(std::string_view title) {
    std::string text(title.substr(0, longest_ae_title));
    text.resize(longest_ae_title, ' ');
    return text;
}

// The items of a list: type, a reserved byte, a length of 16 bits, content.
class ItemReader {
  public:
    explicit ItemReader(std::string_view bytes) : rest_(bytes) {}

    // False at the end, and where the length does not fit: then is_broken().
    bool next() {
        if (rest_.empty()) return false;
        if (rest_.size() < 4 || short_at(rest_, 2) > rest_.size() - 4) {
            is_broken_ = true;
            return false;
        }
        type_ = byte_at(rest_, 0);
        content_ = rest_.substr(4, short_at(rest_, 2));
        rest_.remove_prefix(4 + content_.size());
        return true;
    }
    std::uint8_t type() const { return type_; }
    std::string_view content() const { return content_; }
    bool is_broken() const { return is_broken_; }

  private:
    std::string_view rest_, content_;
    std::uint8_t type_ = 0;
    bool is_broken_ = false;
};

bool parse_context(std::string_view content, bool is_request, std::bitset<256>& seen, Association& out) {
    if (content.size() < 4) return false;
    PresentationContext context;
    context.id = byte_at(content, 0);
    context.result = is_request ? context_accepted : byte_at(content, 2);
    if (context.id % 2 == 0 || seen[context.id] || out.contexts.size() == most_presentation_contexts)
        return false;
    seen[context.id] = true;
    ItemReader items(content.substr(4));
    while (items.next()) {
        const std::string_view name = without_padding(items.content());
        if (name.size() > longest_uid) return false;
        if (items.type() == abstract_item) {
            if (!context.abstract_syntax.empty()) return false;
            context.abstract_syntax = name;
        } else if (items.type() == transfer_item) {
            context.transfer_syntaxes.emplace_back(name);
        } else {
            return false;
        }
    }
    if (items.is_broken() || (is_request && context.abstract_syntax.empty())) return false;
    out.contexts.push_back(std::move(context));
    return true;
}

bool parse_role(std::string_view content, Association& out) {
    if (content.size() < 4) return false;
    const std::size_t length = short_at(content, 0);
    if (length > longest_uid || content.size() != length + 4) return false;
    out.roles.push_back({std::string(without_padding(content.substr(2, length))),
                         byte_at(content, length + 2) == 1, byte_at(content, length + 3) == 1});
    return true;
}

bool parse_user_items(std::string_view content, Association& out) {
    ItemReader items(content);
    while (items.next()) {
        if (items.type() == longest_item) {
            if (items.content().size() != 4) return false;
            out.longest_pdu = long_at(items.content(), 0);
        } else if (items.type() == role_item && out.roles.size() < most_presentation_contexts) {
            if (!parse_role(items.content(), out)) return false;
        }
    }
    // A body of 6 bytes holds the head of a fragment and nothing of it.
    return !items.is_broken() && (out.longest_pdu == 0 || out.longest_pdu > 6);
}

}  // namespace

PduHeader parse_pdu_header(std::string_view bytes) {
    assert(bytes.size() >= pdu_header_bytes);
    return {byte_at(bytes, 0), long_at(bytes, 2)};
}

std::string text_of(const Rejection& rejection) {
    if (rejection == rejected_called) return "the called AE title is not that of the peer";
    if (rejection == rejected_calling) return "the calling AE title is not known there";
    if (rejection == rejected_application_context) return "the application context is not supported";
    if (rejection == rejected_protocol) return "the protocol version is not supported";
    if (rejection.source == 3 && rejection.reason == 1) return "the peer is busy";
    if (rejection == rejected_limit) return "the peer has too many associations";
    return rejection.result == 2 ? "no reason given, for now" : "no reason given";
}

std::string format_associate(PduType type, const Association& association) {
    const bool is_request = type == PduType::associate_request;
    std::string body;
    append_short(body, association.protocol_version);
    append_short(body, 0);
    body += padded_title(association.called);
    body += padded_title(association.calling);
    body.append(32, '\0');
    append_item(
        body, application_item,
        association.application_context.empty() ? application_context_name : association.application_context);
    for (const PresentationContext& context : association.contexts) {
        std::string content{static_cast<char>(context.id), '\0', static_cast<char>(context.result), '\0'};
        if (is_request) append_item(content, abstract_item, context.abstract_syntax);
        for (const std::string& syntax : context.transfer_syntaxes)
            append_item(content, transfer_item, syntax);
        append_item(body, is_request ? request_context_item : accept_context_item, content);
    }
    std::string user, number;
    append_long(number, association.longest_pdu);
    append_item(user, longest_item, number);
    append_item(user, class_item, implementation_class_uid);
    for (const RoleSelection& role : association.roles) {
        std::string content;
        append_short(content, role.sop_class.size());
        content += role.sop_class;
        content += role.is_client ? '\1' : '\0';
        content += role.is_server ? '\1' : '\0';
        append_item(user, role_item, content);
    }
    append_item(user, version_item, implementation_version);
    append_item(body, user_item, user);
    return pdu(type, body);
}

std::string format_reject(const Rejection& rejection) {
    const char body[] = {0, static_cast<char>(rejection.result), static_cast<char>(rejection.source),
                         static_cast<char>(rejection.reason)};
    return pdu(PduType::associate_reject, {body, sizeof body});
}

std::string format_abort(AbortReason reason) {
    const char body[] = {0, 0, 2, static_cast<char>(reason)};
    return pdu(PduType::abort, {body, sizeof body});
}

std::string format_release(PduType type) {
    return pdu(type, std::string(4, '\0'));
}

std::optional<Association> parse_associate(PduType type, std::string_view body) {
    if (body.size() < fixed_associate_bytes) return std::nullopt;
    const bool is_request = type == PduType::associate_request;
    Association out;
    out.protocol_version = short_at(body, 0);
    out.called = without_padding(body.substr(4, longest_ae_title));
    out.calling = without_padding(body.substr(20, longest_ae_title));
    std::bitset<256> seen;
    ItemReader items(body.substr(fixed_associate_bytes));
    while (items.next()) {
        if (items.type() == application_item) {
            out.application_context = without_padding(items.content());
        } else if (items.type() == (is_request ? request_context_item : accept_context_item)) {
            if (!parse_context(items.content(), is_request, seen, out)) return std::nullopt;
        } else if (items.type() == user_item && !parse_user_items(items.content(), out)) {
            return std::nullopt;
        }
    }
    if (items.is_broken()) return std::nullopt;
    return out;
}

std::optional<Rejection> parse_reject(std::string_view body) {
    if (body.size() != 4) return std::nullopt;
    return Rejection{byte_at(body, 1), byte_at(body, 2), byte_at(body, 3)};
}

std::optional<std::vector<DataFragment>> parse_data(std::string_view body) {
    std::vector<DataFragment> fragments;
    while (!body.empty()) {
        if (body.size() < 6) return std::nullopt;
        const std::uint32_t length = long_at(body, 0);
        if (length < 2 || length > body.size() - 4) return std::nullopt;
        const std::uint8_t control = byte_at(body, 5);
        fragments.push_back(
            {byte_at(body, 4), (control & 1) != 0, (control & 2) != 0, body.substr(6, length - 2)});
        body.remove_prefix(4 + length);
    }
    if (fragments.empty()) return std::nullopt;
    return fragments;
}

void append_data(std::string& out, std::uint8_t context, bool is_command, bool is_last,
                 std::string_view bytes, std::uint32_t longest_pdu) {
    assert(longest_pdu == 0 || longest_pdu > 6);
    const std::uint32_t longest =
        longest_pdu == 0 ? longest_pdu_body : std::min(longest_pdu, longest_pdu_body);
    do {
        const std::string_view part = bytes.substr(0, longest - 6);
        bytes.remove_prefix(part.size());
        out += static_cast<char>(PduType::data);
        out += '\0';
        append_long(out, static_cast<std::uint32_t>(part.size() + 6));
        append_long(out, static_cast<std::uint32_t>(part.size() + 2));
        out += static_cast<char>(context);
        out += static_cast<char>((is_command ? 1 : 0) | (is_last && bytes.empty() ? 2 : 0));
        out += part;
    } while (!bytes.empty());
}

bool is_uid(std::string_view text) {
    if (text.empty() || text.size() > longest_uid) return false;
    bool after_point = true;
    for (const char c : text) {
        if (c == '.' ? after_point : c < '0' || c > '9') return false;
        after_point = c == '.';
    }
    return !after_point;
}

bool is_ae_title(std::string_view text) {
    if (text.empty() || text.size() > longest_ae_title) return false;
    const bool printable =
        std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7F && c != '\\'; });
    return printable && !without_padding(text).empty();
}

}  // namespace anatomesh
