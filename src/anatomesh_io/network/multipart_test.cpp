#include "anatomesh_io/network/multipart.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace anatomesh::multipart_test {
namespace {

struct Parts {
    std::vector<std::string> parts;
    std::size_t ended = 0;
    MultipartReader::Sink sink() {
        return {[this] {
                    parts.emplace_back();
                    return true;
                },
                [this](std::string_view bytes) {
                    parts.back() += bytes;
                    return true;
                },
                [this] {
                    ++ended;
                    return true;
                }};
    }
};

std::string message(const std::vector<std::string>& parts, const std::string& preamble) {
    std::string text = preamble;
    for (const std::string& part : parts) text += "\r\n--b\r\nContent-Type: application/dicom\r\n\r\n" + part;
    return text + "\r\n--b--\r\nepilogue";
}

TEST(Multipart, parts_come_back_whatever_the_pieces) {
    std::mt19937 random(5);
    for (int round = 0; round < 300; ++round) {
        std::vector<std::string> wanted(1 + random() % 4);
        for (std::string& part : wanted) {
            // Much of what could begin a boundary.
            const char letters[] = "\r\n--bx";
            for (std::size_t i = random() % 200; i > 0; --i) part += letters[random() % 6];
            while (part.find("\r\n--b") != std::string::npos) part.erase(part.find("\r\n--b"), 1);
        }
        const std::string text = message(wanted, round % 2 == 0 ? "" : "preamble");
        Parts got;
        MultipartReader reader("b", got.sink());
        for (std::size_t at = 0; at < text.size();) {
            const std::size_t size = 1 + random() % 20;
            ASSERT_TRUE(reader.feed(std::string_view(text).substr(at, size)));
            at += size;
        }
        EXPECT_TRUE(reader.is_complete());
        EXPECT_EQ(got.parts, wanted);
        EXPECT_EQ(got.ended, wanted.size());
    }
}

TEST(Multipart, a_boundary_at_the_very_beginning_and_parts_without_headers) {
    Parts got;
    MultipartReader reader("b", got.sink());
    EXPECT_TRUE(reader.feed("--b\r\n\r\none\r\n--b\r\n\r\ntwo\r\n--b--"));
    EXPECT_EQ(got.parts, (std::vector<std::string>{"one", "two"}));
}

TEST(Multipart, what_is_cut_off_is_not_complete) {
    const std::string text = message({"one", "two"}, "");
    const std::size_t last = text.find("--b--") + 5;
    for (std::size_t size = 0; size < last; ++size) {
        Parts got;
        MultipartReader reader("b", got.sink());
        EXPECT_TRUE(reader.feed(text.substr(0, size)));
        EXPECT_FALSE(reader.is_complete());
    }
}

TEST(Multipart, headers_without_end_are_refused) {
    Parts got;
    MultipartReader reader("b", got.sink());
    bool goes_on = reader.feed("--b\r\n");
    for (int i = 0; i < 100 && goes_on; ++i) goes_on = reader.feed(std::string(1000, 'h'));
    EXPECT_FALSE(goes_on);
}

TEST(Multipart, boundaries_of_content_types) {
    EXPECT_EQ(boundary_of("multipart/related; type=\"application/dicom\"; boundary=abc"), "abc");
    EXPECT_EQ(boundary_of("Multipart/Related; Boundary=\"a b;c\"; type=x"), "a b;c");
    EXPECT_FALSE(boundary_of("application/dicom"));
    EXPECT_FALSE(boundary_of("multipart/related; type=x"));
    EXPECT_FALSE(boundary_of("multipart/related; boundary=" + std::string(71, 'b')));
}

}  // namespace
}  // namespace anatomesh::multipart_test
