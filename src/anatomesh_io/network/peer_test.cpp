#include "anatomesh_io/network/peer.h"

#include <gtest/gtest.h>

#include "anatomesh_io/network/dicom_json.h"
#include "anatomesh_io/network/http_client.h"
#include "anatomesh_io/network/query.h"

namespace anatomesh::peer_test {
namespace {

TEST(Peer, titles_hosts_ports_and_urls) {
    const auto plain = parse_peer("ORTHANC@pacs.example");
    ASSERT_TRUE(plain.ok());
    EXPECT_EQ(plain.value().dicom->title, "ORTHANC");
    EXPECT_EQ(plain.value().dicom->host, "pacs.example");
    EXPECT_EQ(plain.value().dicom->port, 104);
    const auto bracketed = parse_peer("A@[::1]:4242");
    ASSERT_TRUE(bracketed.ok());
    EXPECT_EQ(bracketed.value().dicom->host, "::1");
    EXPECT_EQ(bracketed.value().dicom->port, 4242);
    const auto web = parse_peer("https://pacs:8443/dicom-web//");
    ASSERT_TRUE(web.ok());
    EXPECT_FALSE(web.value().dicom);
    EXPECT_EQ(web.value().url, "https://pacs:8443/dicom-web");
    for (const char* text : {"", "@h", "h:104", "A@", "A@h:", "A@h:+1", "A@h:65536", "A@[::1", "A@h:1x",
                             "http://", "http://:80/", "http://h/?q", "https://u@h/", "A B @ h", "A\\B@h"})
        EXPECT_FALSE(parse_peer(text).ok()) << text;
}

TEST(Peer, texts_of_urls) {
    EXPECT_EQ(url_escaped("1.2.3"), "1.2.3");
    EXPECT_EQ(url_escaped("a b/\xc3\xa4*"), "a%20b%2F%C3%A4%2A");
}

TEST(DicomJson, values) {
    const auto parsed = parse_dicom_json(
        R"({"00100010":{"vr":"PN","Value":[{"Alphabetic":"Doe^Jane"}]},"00080061":{"vr":"CS","Value":["CT","MR"]},
            "00201208":{"vr":"IS","Value":[21]},"00100020":{"vr":"LO"}})",
        "application/dicom+json", "url");
    ASSERT_TRUE(parsed.ok());
    EXPECT_EQ(json_text_of(parsed.value(), {0x0010, 0x0010}), "Doe^Jane");
    EXPECT_EQ(json_text_of(parsed.value(), {0x0008, 0x0061}), "CT\\MR");
    EXPECT_EQ(json_text_of(parsed.value(), {0x0010, 0x0020}), "");
    EXPECT_EQ(json_number_of(parsed.value(), {0x0020, 0x1208}), 21u);
}

TEST(DicomJson, what_is_none) {
    EXPECT_FALSE(parse_dicom_json("<html>", "text/html", "url").ok());
    EXPECT_FALSE(parse_dicom_json(std::string(100000, '['), "", "url").ok());
    EXPECT_TRUE(parse_dicom_json(" \n", "", "url").ok());
    for (const char* text : {"[]", "7", "{\"00100010\":7}", "{\"00100010\":{\"Value\":7}}",
                             "{\"00100010\":{\"Value\":[{}]}}", "{\"00100010\":{\"Value\":[null,[]]}}"}) {
        const auto parsed = parse_dicom_json(text, "", "url");
        ASSERT_TRUE(parsed.ok()) << text;
        static_cast<void>(json_text_of(parsed.value(), {0x0010, 0x0010}));
        EXPECT_FALSE(json_number_of(parsed.value(), {0x0010, 0x0010})) << text;
    }
}

TEST(Query, every_keyword_is_found_once) {
    for (const QueryAttribute& each : query_attributes()) EXPECT_EQ(find_attribute(each.keyword), &each);
    EXPECT_EQ(find_attribute("Nonsense"), nullptr);
}

}  // namespace
}  // namespace anatomesh::peer_test
