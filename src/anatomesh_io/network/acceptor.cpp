#include "anatomesh_io/network/acceptor.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace anatomesh {

namespace {

constexpr std::array readable_syntaxes{
    std::string_view("1.2.840.10008.1.2"),       // implicit VR little endian
    std::string_view("1.2.840.10008.1.2.1"),     // explicit VR little endian
    std::string_view("1.2.840.10008.1.2.2"),     // explicit VR big endian
    std::string_view("1.2.840.10008.1.2.4.50"),  // JPEG baseline
    std::string_view("1.2.840.10008.1.2.4.51"),  // JPEG extended
    std::string_view("1.2.840.10008.1.2.4.57"),  // JPEG lossless
    std::string_view("1.2.840.10008.1.2.4.70"),  // JPEG lossless, first-order prediction
    std::string_view("1.2.840.10008.1.2.4.80"),  // JPEG-LS lossless
    std::string_view("1.2.840.10008.1.2.4.81"),  // JPEG-LS near-lossless
    std::string_view("1.2.840.10008.1.2.4.90"),  // JPEG 2000 lossless
    std::string_view("1.2.840.10008.1.2.4.91"),  // JPEG 2000
    std::string_view("1.2.840.10008.1.2.5")};    // RLE

std::string chosen_syntax(const PresentationContext& context) {
    const auto offers = [&](std::string_view syntax) {
        return std::find(context.transfer_syntaxes.begin(), context.transfer_syntaxes.end(), syntax) !=
               context.transfer_syntaxes.end();
    };
    const bool has_long_lists = context.abstract_syntax == rtstruct_class;
    for (const char* syntax : {has_long_lists ? implicit_little_syntax : explicit_little_syntax,
                               has_long_lists ? explicit_little_syntax : implicit_little_syntax})
        if (offers(syntax)) return syntax;
    for (const std::string& syntax : context.transfer_syntaxes)
        if (is_readable_syntax(syntax)) return syntax;
    return {};
}

}  // namespace

bool is_readable_syntax(std::string_view transfer_syntax) {
    return std::find(readable_syntaxes.begin(), readable_syntaxes.end(), transfer_syntax) !=
           readable_syntaxes.end();
}

std::vector<std::string> compressed_syntaxes() {
    std::vector<std::string> syntaxes;
    for (const std::string_view syntax : readable_syntaxes)
        if (syntax != implicit_little_syntax && syntax != explicit_little_syntax &&
            syntax != explicit_big_syntax)
            syntaxes.emplace_back(syntax);
    return syntaxes;
}

std::vector<PresentationContext> answer_contexts(const std::vector<PresentationContext>& asked) {
    std::vector<PresentationContext> answers;
    for (const PresentationContext& each : asked) {
        PresentationContext answer{each.id, each.abstract_syntax, {chosen_syntax(each)}, context_accepted};
        if (each.abstract_syntax != verification_class && !is_storage_class(each.abstract_syntax))
            answer.result = context_no_abstract_syntax;
        else if (answer.transfer_syntaxes[0].empty())
            answer.result = context_no_transfer_syntax;
        // A refused context needs a syntax too, which means nothing.
        if (answer.result != context_accepted) answer.transfer_syntaxes = {implicit_little_syntax};
        answers.push_back(std::move(answer));
    }
    return answers;
}

void Acceptor::receive(std::string_view bytes) {
    input_ += bytes;
    std::size_t at = 0;
    while (state_ != State::over && input_.size() - at >= pdu_header_bytes) {
        const std::string_view rest = std::string_view(input_).substr(at);
        const PduHeader header = parse_pdu_header(rest);
        if (header.type < 1 || header.type > 7) {
            refuse(AbortReason::unrecognized_pdu, "it does not speak DICOM");
            break;
        }
        if (header.length > longest_pdu_body) {
            refuse(AbortReason::invalid_parameter, "a protocol data unit is too long");
            break;
        }
        if (rest.size() < pdu_header_bytes + header.length) break;
        take(header.type, rest.substr(pdu_header_bytes, header.length));
        at += pdu_header_bytes + header.length;
    }
    if (state_ == State::over) at = input_.size();
    input_.erase(0, at);
}

void Acceptor::abort(AbortReason reason) {
    if (state_ == State::over) return;
    // Nobody waits for an abort who has not associated.
    if (state_ == State::associated) output_ += format_abort(reason);
    sink_.reset();
    state_ = State::over;
}

// After an abort the peer closes; what does not speak DICOM, or goes on talking, is closed at once.
void Acceptor::refuse(AbortReason reason, const std::string& why) {
    output_ += format_abort(reason);
    sink_.reset();
    const bool is_foreign = state_ == State::parting || reason == AbortReason::unrecognized_pdu;
    if (state_ != State::parting) rules_->complain(why);
    state_ = is_foreign ? State::over : State::parting;
}

void Acceptor::take(std::uint8_t type, std::string_view body) {
    const auto pdu = static_cast<PduType>(type);
    if (pdu == PduType::abort) {
        if (state_ == State::associated) rules_->complain("the peer aborted");
        sink_.reset();
        state_ = State::over;
        return;
    }
    if (state_ == State::parting) {
        // Only another request is answered; the rest was on its way already.
        if (pdu == PduType::associate_request) refuse(AbortReason::unexpected_pdu, {});
        return;
    }
    if (state_ == State::waiting && pdu == PduType::associate_request) return take_request(body);
    if (state_ == State::associated && pdu == PduType::data) return take_data(body);
    if (state_ == State::associated && pdu == PduType::release_request && !is_within_message()) {
        output_ += format_release(PduType::release_reply);
        state_ = State::parting;
        return;
    }
    refuse(AbortReason::unexpected_pdu, "a protocol data unit came out of turn");
}

void Acceptor::take_request(std::string_view body) {
    std::optional<Association> asked = parse_associate(PduType::associate_request, body);
    if (!asked) return refuse(AbortReason::invalid_parameter, "its request is malformed");
    association_ = std::move(*asked);
    std::optional<Rejection> rejection;
    if ((association_.protocol_version & 1) == 0)
        rejection = rejected_protocol;
    else if (association_.application_context != application_context_name)
        rejection = rejected_application_context;
    else
        rejection = rules_->admit(association_);
    if (rejection) {
        output_ += format_reject(*rejection);
        state_ = State::parting;
        return;
    }
    association_.contexts = answer_contexts(association_.contexts);
    Association answer = association_;
    answer.longest_pdu = longest_pdu_body;
    answer.roles.clear();
    output_ += format_associate(PduType::associate_accept, answer);
    state_ = State::associated;
}

void Acceptor::take_data(std::string_view body) {
    const auto fragments = parse_data(body);
    if (!fragments) return refuse(AbortReason::invalid_parameter, "a P-DATA unit is malformed");
    for (const DataFragment& fragment : *fragments) {
        const bool is_known = std::any_of(
            association_.contexts.begin(), association_.contexts.end(), [&](const PresentationContext& each) {
                return each.id == fragment.context && each.result == context_accepted;
            });
        if (!is_known)
            return refuse(AbortReason::invalid_parameter, "data in a context that was not accepted");
        if (!assembler_.feed(fragment, *this))
            return refuse(AbortReason::invalid_parameter, "a command is malformed or out of place");
        if (state_ != State::associated) return;
    }
}

void Acceptor::command(std::uint8_t context, const Command& command) {
    context_ = context;
    request_ = command;
    failure_ = dimse::success;
    sink_.reset();
    if (command.field == dimse::cancel_request) return;  // there is nothing that could be cancelled
    if (command.is_reply()) return refuse(AbortReason::not_specified, "a reply to no request");
    if (command.field == dimse::store_request)
        begin_store(context, command);
    else if (command.field != dimse::echo_request)
        failure_ = dimse::no_such_operation;
    if (!command.has_data_set) reply(failure_);
}

void Acceptor::begin_store(std::uint8_t context, const Command& command) {
    const auto found = std::find_if(association_.contexts.begin(), association_.contexts.end(),
                                    [&](const PresentationContext& each) { return each.id == context; });
    assert(found != association_.contexts.end());
    if (!command.has_data_set || command.sop_instance.empty())
        failure_ = dimse::cannot_understand;
    else if (command.sop_class != found->abstract_syntax)
        failure_ = dimse::does_not_match_class;
    else
        sink_ = rules_->store({command.sop_class, command.sop_instance, found->transfer_syntaxes[0]});
}

void Acceptor::data(std::string_view bytes) {
    if (sink_) sink_->write(bytes);
}

void Acceptor::end_of_data() {
    if (request_.field == dimse::cancel_request) return;
    const std::uint16_t status = sink_ ? sink_->finish() : failure_;
    sink_.reset();
    reply(status);
}

void Acceptor::reply(std::uint16_t status) {
    Command answer;
    answer.field = request_.field | 0x8000;
    answer.replied_to = request_.message;
    answer.status = status;
    answer.sop_class = request_.sop_class.substr(0, longest_uid);
    answer.sop_instance = request_.sop_instance.substr(0, longest_uid);
    append_data(output_, context_, true, true, format_command(answer), association_.longest_pdu);
}

}  // namespace anatomesh
