#include "anatomesh_io/network/pdu.h"

#include <gtest/gtest.h>

#include <random>

namespace anatomesh::pdu_test {
namespace {

Association some_association() {
    Association association;
    association.called = "ARCHIVE";
    association.calling = "ANATOMESH";
    association.longest_pdu = 16384;
    association.contexts = {
        {1, "1.2.840.10008.1.1", {"1.2.840.10008.1.2"}, 0},
        {3, "1.2.840.10008.5.1.4.1.1.2", {"1.2.840.10008.1.2.1", "1.2.840.10008.1.2"}, 0}};
    association.roles = {{"1.2.840.10008.5.1.4.1.1.2", false, true}};
    return association;
}

std::string body_of(const std::string& pdu) {
    return pdu.substr(pdu_header_bytes);
}

TEST(Pdu, request_comes_back_as_it_was) {
    const Association before = some_association();
    const std::string bytes = format_associate(PduType::associate_request, before);
    const PduHeader header = parse_pdu_header(bytes);
    EXPECT_EQ(header.type, 1);
    ASSERT_EQ(header.length, bytes.size() - pdu_header_bytes);
    const auto after = parse_associate(PduType::associate_request, body_of(bytes));
    ASSERT_TRUE(after);
    EXPECT_EQ(after->called, "ARCHIVE");
    EXPECT_EQ(after->calling, "ANATOMESH");
    EXPECT_EQ(after->longest_pdu, 16384u);
    ASSERT_EQ(after->contexts.size(), 2u);
    EXPECT_EQ(after->contexts[1].transfer_syntaxes, before.contexts[1].transfer_syntaxes);
    ASSERT_EQ(after->roles.size(), 1u);
    EXPECT_TRUE(after->roles[0].is_server);
    EXPECT_FALSE(after->roles[0].is_client);
}

TEST(Pdu, A06_contexts_even_repeated_or_too_many) {
    for (const auto& ids : std::vector<std::vector<int>>{{2}, {0}, {1, 1}}) {
        Association association = some_association();
        association.contexts.clear();
        for (const int id : ids)
            association.contexts.push_back({static_cast<std::uint8_t>(id), "1.2", {"1.2"}, 0});
        EXPECT_FALSE(parse_associate(PduType::associate_request,
                                     body_of(format_associate(PduType::associate_request, association))));
    }
    Association full = some_association();
    full.contexts.clear();
    for (int id = 1; id < 256; id += 2)
        full.contexts.push_back({static_cast<std::uint8_t>(id), "1.2", {"1.2"}, 0});
    std::string body = body_of(format_associate(PduType::associate_request, full));
    EXPECT_TRUE(parse_associate(PduType::associate_request, body));
    // The 129th can only be a repeated one.
    body += std::string(
        "\x20\0\0\x0c\x01\0\0\0\x30\0\0\x04"
        "1.23",
        16);
    EXPECT_FALSE(parse_associate(PduType::associate_request, body));
}

TEST(Pdu, A06_lengths_that_lie_at_every_byte) {
    const std::string body = body_of(format_associate(PduType::associate_request, some_association()));
    for (std::size_t size = 0; size < body.size(); ++size)
        static_cast<void>(parse_associate(PduType::associate_request, body.substr(0, size)));
    std::mt19937 random(7);
    for (int i = 0; i < 20000; ++i) {
        std::string changed = body;
        for (int k = 0; k < 3; ++k) changed[random() % changed.size()] = static_cast<char>(random());
        static_cast<void>(parse_associate(PduType::associate_request, changed));
        static_cast<void>(parse_data(changed));
    }
    // A context that says it is longer than what is there.
    std::string lying = body;
    lying[68 + 4 + 21 + 2] = '\x7f';
    EXPECT_FALSE(parse_associate(PduType::associate_request, lying));
}

TEST(Pdu, A06_ten_thousand_user_items) {
    Association association = some_association();
    association.roles.clear();
    for (int i = 0; i < 3000; ++i) association.roles.push_back({"1.2.3", true, true});
    const auto parsed = parse_associate(PduType::associate_request,
                                        body_of(format_associate(PduType::associate_request, association)));
    ASSERT_TRUE(parsed);
    EXPECT_LE(parsed->roles.size(), 128u);
}

TEST(Pdu, data_in_pieces_of_any_size_comes_back) {
    std::string bytes(1000, 'x');
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7);
    for (const std::uint32_t longest : {7u, 8u, 128u, 1005u, 1006u, 1007u, 0u}) {
        std::string out;
        append_data(out, 5, false, true, bytes, longest);
        std::string back;
        bool last = false;
        for (std::size_t at = 0; at < out.size();) {
            const PduHeader header = parse_pdu_header(std::string_view(out).substr(at));
            EXPECT_EQ(header.type, 4);
            if (longest > 0) {
                EXPECT_LE(header.length, longest);
            }
            const auto fragments = parse_data(std::string_view(out).substr(at + 6, header.length));
            ASSERT_TRUE(fragments);
            for (const DataFragment& fragment : *fragments) {
                EXPECT_FALSE(last);
                EXPECT_EQ(fragment.context, 5);
                EXPECT_FALSE(fragment.is_command);
                back += fragment.bytes;
                last = fragment.is_last;
            }
            at += 6 + header.length;
        }
        EXPECT_TRUE(last);
        EXPECT_EQ(back, bytes);
    }
}

TEST(Pdu, A05_data_with_lengths_that_lie) {
    EXPECT_FALSE(parse_data(""));
    EXPECT_FALSE(parse_data(std::string("\0\0\0\0", 4)));
    EXPECT_FALSE(parse_data(std::string("\0\0\0\1\1\0", 6)));
    EXPECT_FALSE(parse_data(std::string("\0\0\0\4\1\0", 6)));
    EXPECT_FALSE(parse_data(std::string("\xff\xff\xff\xff\1\0ab", 8)));
    EXPECT_TRUE(parse_data(std::string("\0\0\0\4\1\0ab", 8)));
    EXPECT_FALSE(parse_data(std::string("\0\0\0\3\1\0ab", 8)));
}

TEST(Pdu, A14_uids_and_titles) {
    for (const char* text : {"1", "1.2.840.10008.1.1", "0.0", "1.02"}) EXPECT_TRUE(is_uid(text)) << text;
    for (const std::string& text :
         {std::string(), std::string("../../x"), std::string("/etc/x"), std::string("."), std::string(".."),
          std::string("1."), std::string(".1"), std::string("1..2"), std::string(65, '1'),
          std::string("1\0", 2), std::string("1.2 "), std::string("1.a")})
        EXPECT_FALSE(is_uid(text)) << text;
    EXPECT_TRUE(is_ae_title("CT 1"));
    for (const std::string& text : {std::string(), std::string("   "), std::string(17, 'A'),
                                    std::string("A\\B"), std::string("A\0", 2), std::string("\xc3\xa4")})
        EXPECT_FALSE(is_ae_title(text));
}

TEST(Pdu, A21_a_longest_unit_that_holds_nothing_is_refused) {
    for (const std::uint32_t longest : {1u, 6u}) {
        Association association = some_association();
        association.longest_pdu = longest;
        EXPECT_FALSE(parse_associate(PduType::associate_request,
                                     body_of(format_associate(PduType::associate_request, association))));
    }
}

}  // namespace
}  // namespace anatomesh::pdu_test
