#include "anatomesh_io/file/byte_reader.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace anatomesh::byte_reader_test {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

TEST(ByteReader, numbers_in_both_orders) {
    const std::string text("\x01\x02\x03\x04\x05\x06\x07\x08", 8);
    ByteReader reader(bytes_of(text));
    EXPECT_EQ(reader.read<std::uint16_t>(), 0x0201);
    reader.set_order(std::endian::big);
    EXPECT_EQ(reader.read<std::uint16_t>(), 0x0304);
    EXPECT_EQ(reader.read<std::uint32_t>(), 0x05060708U);
    EXPECT_EQ(reader.remaining(), 0U);
    EXPECT_FALSE(reader.read<std::uint8_t>());
    ASSERT_TRUE(reader.seek(0));
    EXPECT_EQ(reader.read<std::uint64_t>(), 0x0102030405060708U);
}

TEST(ByteReader, nothing_is_read_or_moved_beyond_the_end) {
    const std::string text = "abc";
    ByteReader reader(bytes_of(text));
    ASSERT_TRUE(reader.skip(1));
    EXPECT_FALSE(reader.read<std::uint32_t>());
    EXPECT_FALSE(reader.read_bytes(3));
    EXPECT_FALSE(reader.read_bytes(std::numeric_limits<std::uint64_t>::max()));
    EXPECT_FALSE(reader.skip(std::numeric_limits<std::uint64_t>::max()));
    EXPECT_FALSE(reader.seek(4));
    EXPECT_EQ(reader.position(), 1U);
    EXPECT_TRUE(reader.seek(3));
    EXPECT_EQ(reader.read_text(0), "");
    EXPECT_FALSE(reader.read_line());
}

TEST(ByteReader, lines_end_with_or_without_carriage_return) {
    const std::string text = "one\r\n\ntwo";
    ByteReader reader(bytes_of(text));
    EXPECT_EQ(reader.read_line(), "one");
    EXPECT_EQ(reader.read_line(), "");
    EXPECT_EQ(reader.read_line(), "two");
    EXPECT_FALSE(reader.read_line());
}

TEST(ByteReader, products_that_do_not_fit_are_nothing) {
    EXPECT_EQ(checked_multiply(1ULL << 31, 1ULL << 32), 1ULL << 63);
    EXPECT_FALSE(checked_multiply(1ULL << 32, 1ULL << 32));
    EXPECT_EQ(checked_multiply(0, ~0ULL), 0U);
}

}  // namespace
}  // namespace anatomesh::byte_reader_test
