#include "anatomesh_io/contour/dicom_layout.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

namespace anatomesh::dicom_layout_test {
namespace {

std::string little(std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i));
    return text;
}

std::string tag(unsigned group, unsigned element) {
    return little(group, 2) + little(element, 2);
}

std::string short_element(unsigned group, unsigned element, const char* vr, const std::string& value) {
    return tag(group, element) + vr + little(value.size(), 2) + value;
}
std::string long_element(unsigned group, unsigned element, const char* vr, const std::string& value,
                         std::uint32_t length) {
    return tag(group, element) + vr + std::string(2, '\0') + little(length, 4) + value;
}
std::string implicit_element(unsigned group, unsigned element, const std::string& value) {
    return tag(group, element) + little(value.size(), 4) + value;
}

std::string file_of(const std::string& syntax, const std::string& data) {
    return std::string(128, '\0') + "DICM" + short_element(2, 0x10, "UI", syntax) + data;
}

const std::string explicit_syntax = "1.2.840.10008.1.2.1", implicit_syntax = "1.2.840.10008.1.2",
                  deflated_syntax = "1.2.840.10008.1.2.1.99";
const std::string item_to_delimiter = tag(0xFFFE, 0xE000) + little(0xFFFFFFFF, 4);
const std::string item_end = tag(0xFFFE, 0xE00D) + little(0, 4),
                  sequence_end = tag(0xFFFE, 0xE0DD) + little(0, 4);

Result<DicomLayout> check(const std::string& file, const DicomLimits& limits = {}) {
    return check_dicom_layout(
        file, "input",
        [](std::uint16_t group, std::uint16_t element) { return group == 0x3006 && element == 0x39; },
        limits);
}

std::string code_of(const Result<DicomLayout>& result) {
    return result.ok() ? "" : result.error().code;
}

std::string nested(int depth, const std::string& content) {
    std::string head, tail;
    for (int i = 0; i < depth; ++i) {
        head += long_element(0x3006, 0x39, "SQ", item_to_delimiter, 0xFFFFFFFF);
        tail += item_end + sequence_end;
    }
    return head + content + tail;
}

TEST(DicomLayout, accepts_what_is_whole) {
    const std::string name = short_element(0x3006, 0x26, "LO", "liver ");
    for (const std::string& data : {std::string(), name, nested(3, name), nested(1, ""),
                                    long_element(0x3006, 0x39, "SQ", "", 0) + name}) {
        const auto layout = check(file_of(explicit_syntax, data));
        ASSERT_TRUE(layout.ok()) << to_line(layout.error());
        EXPECT_EQ(layout.value().data_set, file_of(explicit_syntax, "").size());
        EXPECT_EQ(layout.value().encoding, DicomEncoding::explicit_little);
    }
    const std::string item = tag(0xFFFE, 0xE000) + little(12, 4) + implicit_element(0x3006, 0x26, "abcd");
    EXPECT_TRUE(check(file_of(implicit_syntax, implicit_element(0x3006, 0x39, item))).ok());
    EXPECT_TRUE(check(file_of(explicit_syntax, long_element(0x3006, 0x39, "UN", item, 20))).ok());
}

TEST(DicomLayout, D01_no_dicom) {
    EXPECT_EQ(code_of(check("")), "E-DCL-001");
    EXPECT_EQ(code_of(check(std::string(131, '\0'))), "E-DCL-001");
    EXPECT_EQ(code_of(check(std::string(128, '\0') + "DICM")), "E-DCL-002");
    EXPECT_EQ(code_of(check(file_of("1.2.3", ""))), "E-DCL-003");
}

TEST(DicomLayout, D04_without_preamble_or_meta_header) {
    const std::string name = short_element(0x0008, 0x0060, "CS", "CT");
    const auto guessed = check(name);
    ASSERT_TRUE(guessed.ok()) << to_line(guessed.error());
    EXPECT_TRUE(guessed.value().is_guessed);
    EXPECT_FALSE(guessed.value().has_meta);
    EXPECT_EQ(guessed.value().transfer_syntax, explicit_syntax);
    const auto implicit = check(implicit_element(0x0008, 0x0060, "CT"));
    ASSERT_TRUE(implicit.ok());
    EXPECT_EQ(implicit.value().encoding, DicomEncoding::implicit_little);
    const auto big =
        check(std::string("\0\x08\0\x60"
                          "CS\0\2CT",
                          10));
    ASSERT_TRUE(big.ok());
    EXPECT_EQ(big.value().encoding, DicomEncoding::explicit_big);
    const auto no_preamble = check(file_of(implicit_syntax, implicit_element(8, 0x60, "CT")).substr(132));
    ASSERT_TRUE(no_preamble.ok()) << to_line(no_preamble.error());
    EXPECT_TRUE(no_preamble.value().has_meta);
    EXPECT_EQ(no_preamble.value().transfer_syntax, implicit_syntax);
    EXPECT_EQ(code_of(check("some text that is no DICOM at all")), "E-DCL-001");
}

TEST(DicomLayout, D05_length_of_the_meta_header) {
    const std::string name = short_element(0x0008, 0x0060, "CS", "CT");
    const std::string syntax = short_element(2, 0x10, "UI", explicit_syntax);
    const auto with_length = [&](const std::string& length) {
        return std::string(128, '\0') + "DICM" + length + syntax + name;
    };
    const auto stated = [&](std::uint32_t value) { return short_element(2, 0, "UL", little(value, 4)); };
    const auto size = static_cast<std::uint32_t>(syntax.size());
    for (const auto& [file, is_right] : {std::pair{with_length(stated(size)), true},
                                         {with_length(""), false},
                                         {with_length(stated(size + 1)), false},
                                         {with_length(stated(0)), false},
                                         {with_length(stated(0xFFFFFFFF)), false},
                                         {with_length(short_element(2, 0, "UL", "")), false}}) {
        const auto layout = check(file);
        ASSERT_TRUE(layout.ok()) << to_line(layout.error());
        EXPECT_EQ(layout.value().transfer_syntax, explicit_syntax);
        EXPECT_EQ(file.substr(layout.value().data_set), name);
        RunContext context;
        warn_of_guess(layout.value(), "input", context);
        ASSERT_EQ(context.warnings.size(), is_right ? 0u : 1u);
        if (!is_right) {
            EXPECT_EQ(context.warnings[0].code, "W-DCL-002");
        }
    }
    // What cannot be known is refused.
    EXPECT_EQ(code_of(check(std::string(128, '\0') + "DICM" + stated(0xFFFFFFFF) + name)), "E-DCL-002");
}

TEST(DicomLayout, compressed_pixels_are_fragments) {
    const std::string fragment = tag(0xFFFE, 0xE000) + little(6, 4);
    // A delimiter within a fragment ends nothing (D-17).
    const std::string pixels = tag(0x7FE0, 0x10) + "OB" + std::string(2, '\0') + little(0xFFFFFFFF, 4) +
                               tag(0xFFFE, 0xE000) + little(0, 4) + fragment +
                               std::string("\xFE\xFF\xDD\xE0\0\0", 6);
    EXPECT_TRUE(check(file_of(explicit_syntax, pixels + sequence_end)).ok());
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, pixels))), "E-DCL-004");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, pixels + fragment + "abc"))), "E-DCL-004");
}

TEST(DicomLayout, D08_lengths_beyond_what_is_left) {
    const auto in_item = [](const std::string& element, std::uint32_t length) {
        return long_element(0x3006, 0x39, "SQ", tag(0xFFFE, 0xE000) + little(length, 4) + element,
                            8 + length);
    };
    const std::string name = short_element(0x3006, 0x26, "LO", "liver ");
    const auto at = check(file_of(explicit_syntax, name + tag(0x3006, 0x28) + "LO" + little(9, 2) + "short"));
    EXPECT_EQ(code_of(at), "E-DCL-004");
    EXPECT_NE(to_line(at.error()).find("(3006,0028) at byte 173"), std::string::npos) << to_line(at.error());
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, long_element(0x3006, 0x50, "OB", "", 0x7FFFFFFF)))),
              "E-DCL-004");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, long_element(0x3006, 0x50, "OB", "", 0xFFFFFFFF)))),
              "E-DCL-007");
    EXPECT_EQ(
        code_of(check(file_of(explicit_syntax, in_item(name, static_cast<std::uint32_t>(name.size()))))), "");
    EXPECT_EQ(
        code_of(check(file_of(explicit_syntax, in_item(name, static_cast<std::uint32_t>(name.size()) - 1)))),
        "E-DCL-004");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, in_item(name, 1000)))), "E-DCL-004");
}

TEST(DicomLayout, D07_vr_that_there_is_not) {
    const auto result = check(std::string(128, '\0') + "DICM" + long_element(2, 2, "ZZ", "", 0x7FFFFFFF));
    EXPECT_EQ(code_of(result), "E-DCL-006");
}

TEST(DicomLayout, D09_depth) {
    const std::string name = short_element(0x3006, 0x26, "LO", "liver ");
    for (const int depth : {16, 64, 128})
        EXPECT_EQ(code_of(check(file_of(explicit_syntax, nested(depth, name)))), "");
    for (const int depth : {129, 257, 1'800, 100'000}) {
        const auto result = check(file_of(explicit_syntax, nested(depth, name)));
        ASSERT_EQ(code_of(result), "E-DCL-005");
        EXPECT_EQ(result.error().kind, ErrorKind::limit);
    }
    // The same, hidden in elements of unknown VR, known to the dictionary, or private.
    for (const unsigned group : {0x3006u, 0x3007u}) {
        std::string inner = implicit_element(0x3006, 0x26, "ab");
        for (int i = 0; i < 200; ++i)
            inner = tag(group, 0x39) + little(inner.size() + 8, 4) + tag(0xFFFE, 0xE000) +
                    little(inner.size(), 4) + inner;
        EXPECT_EQ(code_of(check(file_of(implicit_syntax, inner))), "E-DCL-005");
        const std::string item = tag(0xFFFE, 0xE000) + little(inner.size(), 4) + inner;
        const auto length = static_cast<std::uint32_t>(item.size());
        EXPECT_EQ(code_of(check(file_of(explicit_syntax, long_element(group, 0x39, "UN", item, length)))),
                  "E-DCL-005");
    }
}

TEST(DicomLayout, D10_delimiters) {
    const std::string sequence = long_element(0x3006, 0x39, "SQ", "", 0xFFFFFFFF);
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, sequence))), "E-DCL-004");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, sequence + item_to_delimiter))), "E-DCL-004");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, sequence + item_to_delimiter + item_end))), "E-DCL-004");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, sequence + item_end))), "E-DCL-007");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, item_end))), "E-DCL-007");
    EXPECT_EQ(code_of(check(file_of(explicit_syntax, sequence_end))), "E-DCL-007");
}

TEST(DicomLayout, private_bytes_that_look_like_a_sequence_are_no_error) {
    const std::string bytes = tag(0xFFFE, 0xE000) + little(1'000'000, 4) + "xyz1";
    const std::string name = implicit_element(0x3006, 0x26, "abcd");
    EXPECT_EQ(code_of(check(file_of(implicit_syntax, implicit_element(0x3007, 0x39, bytes) + name))), "");
    EXPECT_EQ(code_of(check(file_of(implicit_syntax, implicit_element(0x3006, 0x39, bytes) + name))),
              "E-DCL-004");
}

std::string deflated(const std::string& data) {
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
    std::string out(deflateBound(&stream, data.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
    stream.avail_in = static_cast<uInt>(data.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

TEST(DicomLayout, D15_deflated_within_limits) {
    const std::string name = short_element(0x3006, 0x26, "LO", "liver ");
    const auto layout = check(file_of(deflated_syntax, deflated(name)));
    ASSERT_TRUE(layout.ok());
    EXPECT_EQ(layout.value().inflated, name);
    EXPECT_EQ(code_of(check(file_of(deflated_syntax, deflated(name).substr(0, 4)))), "E-DCL-008");
    EXPECT_EQ(code_of(check(file_of(deflated_syntax, "xx"))), "E-DCL-008");
    EXPECT_EQ(code_of(check(file_of(deflated_syntax, ""))), "E-DCL-008");
    const std::string bomb =
        deflated(long_element(0x3006, 0x50, "OB", std::string(std::size_t{40} << 20, '\0'), 40u << 20));
    const auto result = check(file_of(deflated_syntax, bomb));
    EXPECT_EQ(code_of(result), "E-DCL-009");
    EXPECT_EQ(code_of(check(file_of(deflated_syntax, bomb), {.inflated_ratio = 2'000})), "");
    EXPECT_EQ(
        code_of(check(file_of(deflated_syntax, bomb), {.inflated_bytes = 1 << 20, .inflated_ratio = 2'000})),
        "E-DCL-009");
}

}  // namespace
}  // namespace anatomesh::dicom_layout_test
