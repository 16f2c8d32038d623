#include "anatomesh_io/network/acceptor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace anatomesh::acceptor_test {
namespace {

constexpr const char* ct_class = "1.2.840.10008.5.1.4.1.1.2";

// An acceptor, and what it did.
class Harness {
  public:
    Harness() {
        rules_.admit = [this](const Association&) { return rejection; };
        rules_.store = [this](const ObjectLabel& label) -> std::unique_ptr<ObjectSink> {
            labels.push_back(label);
            return std::make_unique<Sink>(*this);
        };
        rules_.complain = [this](const std::string& what) { complaints.push_back(what); };
        acceptor = std::make_unique<Acceptor>(rules_);
    }

    // Associates with verification (1), CT (3), RTSTRUCT (5) and a query (7).
    void associate(std::uint32_t longest_pdu = 16384) {
        acceptor->receive(request(longest_pdu));
        EXPECT_EQ(acceptor->state(), Acceptor::State::associated);
        acceptor->output().clear();
    }
    static std::string request(std::uint32_t longest_pdu = 16384) {
        Association asked;
        asked.called = "ANATOMESH";
        asked.calling = "SCANNER";
        asked.longest_pdu = longest_pdu;
        const std::vector<std::string> plain{explicit_little_syntax, implicit_little_syntax};
        asked.contexts = {{1, verification_class, {implicit_little_syntax}, 0},
                          {3, ct_class, plain, 0},
                          {5, rtstruct_class, plain, 0},
                          {7, "1.2.840.10008.5.1.4.1.2.2.1", plain, 0},
                          {9, ct_class, {"1.2.840.10008.1.2.1.99"}, 0},
                          {11, ct_class, {}, 0}};
        return format_associate(PduType::associate_request, asked);
    }
    static Command store_command() {
        Command command;
        command.field = dimse::store_request;
        command.message = 17;
        command.sop_class = ct_class;
        command.sop_instance = "1.2.3";
        command.has_data_set = true;
        return command;
    }
    void send(const Command& command, std::uint8_t context = 3) {
        std::string bytes;
        append_data(bytes, context, true, true, format_command(command), 16384);
        acceptor->receive(bytes);
    }
    void send_data(std::string_view data, std::uint8_t context = 3, std::uint32_t longest = 16384) {
        std::string bytes;
        append_data(bytes, context, false, true, data, longest);
        acceptor->receive(bytes);
    }
    // The types of the units that it has answered with.
    std::vector<int> answers() const {
        std::vector<int> types;
        const std::string& out = acceptor->output();
        for (std::size_t at = 0; at < out.size();) {
            const PduHeader header = parse_pdu_header(std::string_view(out).substr(at));
            types.push_back(header.type);
            at += 6 + header.length;
        }
        return types;
    }
    // The command that it has answered with.
    Command reply() const {
        struct Collect : MessageAssembler::Sink {
            Command got;
            void command(std::uint8_t, const Command& command) override { got = command; }
            void data(std::string_view) override {}
            void end_of_data() override {}
        } collect;
        MessageAssembler assembler;
        const std::string& out = acceptor->output();
        for (std::size_t at = 0; at < out.size();) {
            const PduHeader header = parse_pdu_header(std::string_view(out).substr(at));
            const auto fragments = parse_data(std::string_view(out).substr(at + 6, header.length));
            EXPECT_TRUE(fragments);
            if (!fragments) break;
            for (const DataFragment& each : *fragments) EXPECT_TRUE(assembler.feed(each, collect));
            at += 6 + header.length;
        }
        return collect.got;
    }

    std::optional<Rejection> rejection;
    std::vector<ObjectLabel> labels;
    std::vector<std::string> stored, complaints;
    int discarded = 0;
    std::uint16_t status = 0;
    std::unique_ptr<Acceptor> acceptor;

  private:
    class Sink : public ObjectSink {
      public:
        explicit Sink(Harness& harness) : harness_(harness) {}
        ~Sink() override { harness_.discarded += !finished_; }
        void write(std::string_view bytes) override { content_ += bytes; }
        std::uint16_t finish() override {
            finished_ = true;
            harness_.stored.push_back(content_);
            return harness_.status;
        }

      private:
        Harness& harness_;
        std::string content_;
        bool finished_ = false;
    };
    Acceptor::Rules rules_;
};

TEST(Acceptor, stores_what_comes_in_any_pieces) {
    for (const std::uint32_t longest : {0u, 7u, 100u}) {
        Harness harness;
        harness.associate();
        harness.send(Harness::store_command());
        EXPECT_TRUE(harness.acceptor->output().empty());
        harness.send_data(std::string(500, 'd'), 3, longest);  // A09: fragments of one byte are legal
        ASSERT_EQ(harness.stored, std::vector<std::string>{std::string(500, 'd')});
        EXPECT_EQ(harness.labels[0].transfer_syntax, explicit_little_syntax);
        const Command reply = harness.reply();
        EXPECT_EQ(reply.field, dimse::store_reply);
        EXPECT_EQ(reply.replied_to, 17);
        EXPECT_EQ(reply.status, 0);
        EXPECT_EQ(reply.sop_instance, "1.2.3");
        harness.acceptor->output().clear();
        harness.acceptor->receive(format_release(PduType::release_request));
        EXPECT_EQ(harness.answers(), std::vector<int>{6});
        EXPECT_TRUE(harness.complaints.empty());
    }
}

TEST(Acceptor, bytes_one_at_a_time_make_no_difference) {
    Harness harness;
    std::string all = Harness::request();
    append_data(all, 3, true, true, format_command(Harness::store_command()), 100);
    append_data(all, 3, false, true, std::string(300, 'd'), 100);
    for (const char c : all) harness.acceptor->receive({&c, 1});
    EXPECT_EQ(harness.stored, std::vector<std::string>{std::string(300, 'd')});
}

TEST(Acceptor, A16_A20_contexts_that_are_not_offered) {
    const auto asked = parse_associate(PduType::associate_request, Harness::request().substr(6));
    ASSERT_TRUE(asked);
    const auto answers = answer_contexts(asked->contexts);
    std::vector<int> results;
    for (const PresentationContext& each : answers) results.push_back(each.result);
    EXPECT_EQ(results, (std::vector<int>{0, 0, 0, 3, 4, 4}));
    EXPECT_EQ(answers[1].transfer_syntaxes[0], explicit_little_syntax);
    EXPECT_EQ(answers[2].transfer_syntaxes[0], implicit_little_syntax);
    Harness harness;
    harness.associate();
    Command query;
    query.field = dimse::find_request;
    query.message = 1;
    query.sop_class = "1.2.840.10008.5.1.4.1.2.2.1";
    query.has_data_set = true;
    harness.send(query, 7);
    EXPECT_EQ(harness.answers(), std::vector<int>{7});
}

TEST(Acceptor, A20_queries_in_a_storage_context_are_refused_cleanly) {
    for (const std::uint16_t field : {dimse::find_request, dimse::move_request, dimse::get_request,
                                      std::uint16_t{0x0130}, std::uint16_t{0x7777}}) {
        Harness harness;
        harness.associate();
        Command command = Harness::store_command();
        command.field = field;
        harness.send(command);
        harness.send_data("a query");
        EXPECT_EQ(harness.reply().status, dimse::no_such_operation);
        EXPECT_EQ(harness.reply().field, field | 0x8000);
        EXPECT_EQ(harness.acceptor->state(), Acceptor::State::associated);
    }
}

TEST(Acceptor, echo) {
    Harness harness;
    harness.associate();
    Command echo;
    echo.field = dimse::echo_request;
    echo.message = 9;
    echo.sop_class = verification_class;
    harness.send(echo, 1);
    EXPECT_EQ(harness.reply().field, dimse::echo_reply);
    EXPECT_EQ(harness.reply().replied_to, 9);
}

TEST(Acceptor, A04_what_is_no_dicom) {
    for (const std::string& text :
         {std::string("GET / HTTP/1.0\r\n\r\n"), std::string("\x16\x03\x01\x02\x00\x01\x00\x01", 8),
          std::string("\x00\x00\x00\x85\xff\x53MB", 8), std::string("\x08\0\0\0\0\0", 6)}) {
        Harness harness;
        harness.acceptor->receive(text);
        EXPECT_EQ(harness.answers(), std::vector<int>{7});
        EXPECT_EQ(harness.acceptor->state(), Acceptor::State::over);
        EXPECT_EQ(harness.complaints.size(), 1u);
    }
}

TEST(Acceptor, A05_lengths_of_units) {
    for (const std::string& text : {std::string("\1\0\xff\xff\xff\xff", 6), std::string("\1\0\0\0\0\0", 6),
                                    std::string("\1\0\0\2\0\1", 6), std::string("\1\0\0\0\0\5hello", 11)}) {
        Harness harness;
        harness.acceptor->receive(text);
        EXPECT_EQ(harness.answers(), std::vector<int>{7});
        EXPECT_NE(harness.acceptor->state(), Acceptor::State::waiting);
    }
}

// The state table of PS3.8: every state against every unit.
TEST(Acceptor, A07_state_table) {
    std::string data;
    append_data(data, 1, true, true, "", 0);
    Association accepted;
    accepted.contexts = {{1, "", {implicit_little_syntax}, 0}};
    const std::vector<std::string> units{Harness::request(),
                                         format_associate(PduType::associate_accept, accepted),
                                         format_reject(rejected_limit),
                                         data,
                                         format_release(PduType::release_request),
                                         format_release(PduType::release_reply),
                                         format_abort(AbortReason::not_specified)};
    using State = Acceptor::State;
    // Answers by unit: 2 accept, 6 release, 7 abort, 0 none.
    const struct {
        State state;
        std::vector<int> answers;
        std::vector<State> next;
    } table[] = {{State::waiting,
                  {2, 7, 7, 7, 7, 7, 0},
                  {State::associated, State::parting, State::parting, State::parting, State::parting,
                   State::parting, State::over}},
                 {State::associated,
                  {7, 7, 7, 7, 6, 7, 0},
                  {State::parting, State::parting, State::parting, State::parting, State::parting,
                   State::parting, State::over}},
                 {State::parting,
                  {7, 0, 0, 0, 0, 0, 0},
                  {State::over, State::parting, State::parting, State::parting, State::parting,
                   State::parting, State::over}}};
    for (const auto& row : table) {
        for (std::size_t i = 0; i < units.size(); ++i) {
            Harness harness;
            if (row.state != State::waiting) harness.associate();
            if (row.state == State::parting)
                harness.acceptor->receive(format_release(PduType::release_request));
            harness.acceptor->output().clear();
            harness.acceptor->receive(units[i]);
            const std::vector<int> wanted =
                row.answers[i] == 0 ? std::vector<int>{} : std::vector<int>{row.answers[i]};
            EXPECT_EQ(harness.answers(), wanted) << int(row.state) << " " << i;
            EXPECT_EQ(harness.acceptor->state(), row.next[i]) << int(row.state) << " " << i;
        }
    }
}

TEST(Acceptor, A08_commands_that_lie) {
    {  // no instance
        Harness harness;
        harness.associate();
        Command command = Harness::store_command();
        command.sop_instance.clear();
        harness.send(command);
        harness.send_data("data");
        EXPECT_EQ(harness.reply().status, dimse::cannot_understand);
    }
    {  // no data set announced
        Harness harness;
        harness.associate();
        Command command = Harness::store_command();
        command.has_data_set = false;
        harness.send(command);
        EXPECT_EQ(harness.reply().status, dimse::cannot_understand);
        harness.acceptor->output().clear();
        harness.send_data("a data set all the same");
        EXPECT_EQ(harness.answers(), std::vector<int>{7});
    }
    {  // another class than the context is for
        Harness harness;
        harness.associate();
        Command command = Harness::store_command();
        command.sop_class = rtstruct_class;
        harness.send(command);
        harness.send_data("data");
        EXPECT_EQ(harness.reply().status, dimse::does_not_match_class);
        EXPECT_TRUE(harness.stored.empty());
    }
    // Lengths that do not fit, at every byte.
    const std::string good = format_command(Harness::store_command());
    for (std::size_t i = 0; i < good.size(); ++i) {
        for (const int value : {0, 0x7f, 0xff}) {
            std::string bad = good;
            bad[i] = static_cast<char>(value);
            Harness harness;
            harness.associate();
            std::string bytes;
            append_data(bytes, 3, true, true, bad, 0);
            harness.acceptor->receive(bytes);
            harness.send_data("data");
            const bool goes_on = harness.acceptor->state() == Acceptor::State::associated;
            EXPECT_FALSE(goes_on && harness.acceptor->is_within_message()) << i << " " << value;
        }
    }
}

TEST(Acceptor, A09_fragments_out_of_place) {
    const auto fragment = [](std::uint8_t context, bool is_command, bool is_last, std::string_view bytes) {
        std::string out;
        append_data(out, context, is_command, is_last, bytes, 0);
        return out;
    };
    const std::string command = format_command(Harness::store_command());
    const std::vector<std::vector<std::string>> wrong{
        {fragment(3, true, false, command.substr(0, 20)), fragment(5, true, true, command.substr(20))},
        {fragment(3, true, true, command), fragment(5, false, true, "data")},
        {fragment(3, true, true, command), fragment(3, true, true, command)},
        {fragment(3, false, true, "data")},
        {fragment(99, true, true, command)}};
    for (const auto& units : wrong) {
        Harness harness;
        harness.associate();
        for (const std::string& unit : units) harness.acceptor->receive(unit);
        EXPECT_EQ(harness.answers(), std::vector<int>{7});
        EXPECT_TRUE(harness.stored.empty());
        EXPECT_EQ(harness.discarded, static_cast<int>(harness.labels.size()));
    }
    // A command that never ends is cut at 64 KiB.
    Harness harness;
    harness.associate();
    for (int i = 0; i < 10 && harness.answers().empty(); ++i)
        harness.acceptor->receive(fragment(3, true, false, std::string(16000, '\0')));
    EXPECT_EQ(harness.answers(), std::vector<int>{7});
}

TEST(Acceptor, A12_what_did_not_end_is_discarded) {
    Harness harness;
    harness.associate();
    harness.send(Harness::store_command());
    std::string bytes;
    append_data(bytes, 3, false, false, "the first half", 0);
    harness.acceptor->receive(bytes);
    EXPECT_TRUE(harness.acceptor->is_within_message());
    harness.acceptor.reset();
    EXPECT_EQ(harness.discarded, 1);
    EXPECT_TRUE(harness.stored.empty());
}

TEST(Acceptor, A03_rejections_are_said) {
    for (const Rejection& rejection :
         {rejected_called, rejected_calling, rejected_no_reason, rejected_limit}) {
        Harness harness;
        harness.rejection = rejection;
        harness.acceptor->receive(Harness::request());
        ASSERT_EQ(harness.answers(), std::vector<int>{3});
        EXPECT_EQ(parse_reject(std::string_view(harness.acceptor->output()).substr(6)), rejection);
    }
    Harness harness;
    std::string version = Harness::request();
    version[7] = 2;
    harness.acceptor->receive(version);
    EXPECT_EQ(parse_reject(std::string_view(harness.acceptor->output()).substr(6)), rejected_protocol);
}

TEST(Acceptor, A21_replies_fit_into_small_units) {
    Harness harness;
    harness.associate(20);
    harness.send(Harness::store_command());
    harness.send_data("data");
    for (std::size_t at = 0; at < harness.acceptor->output().size();) {
        const PduHeader header = parse_pdu_header(std::string_view(harness.acceptor->output()).substr(at));
        EXPECT_LE(header.length, 20u);
        at += 6 + header.length;
    }
    EXPECT_EQ(harness.reply().replied_to, 17);
}

// A17: whatever comes, it neither crashes nor keeps more than a unit.
TEST(Acceptor, A17_random_changes_of_a_conversation) {
    std::string good = Harness::request();
    append_data(good, 3, true, true, format_command(Harness::store_command()), 100);
    append_data(good, 3, false, true, std::string(300, 'd'), 100);
    good += format_release(PduType::release_request);
    std::mt19937 random(11);
    for (int i = 0; i < 20000; ++i) {
        std::string bytes = good;
        const int changes = 1 + static_cast<int>(random() % 4);
        for (int k = 0; k < changes; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
        Harness harness;
        harness.acceptor->receive(bytes);
    }
}

}  // namespace
}  // namespace anatomesh::acceptor_test
