#include "anatomesh/base/text.h"

#include <gtest/gtest.h>

namespace anatomesh::text_test {
namespace {

TEST(Text, tells_utf8_from_other_bytes) {
    for (const char* text :
         {"", "k = 12", "\xC3\xA4", "\xE2\x82\xAC", "\xF0\x9F\xAB\x80", "\xF4\x8F\xBF\xBF"})
        EXPECT_TRUE(is_utf8(text)) << text;
    for (const char* text :
         {"\xC3", "\xA4", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF", "a\xC3z"})
        EXPECT_FALSE(is_utf8(text)) << text;
    EXPECT_FALSE(is_utf8(std::string_view("a\0b", 3)));
    EXPECT_EQ(utf8_length("\xE2\x82\xAC rest"), 3u);
}

}  // namespace
}  // namespace anatomesh::text_test
