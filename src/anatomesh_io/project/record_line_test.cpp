#include "anatomesh_io/project/record_line.h"

#include <gtest/gtest.h>

#include <random>

namespace anatomesh::record_line_test {
namespace {

using End = RecordScan::End;

TEST(RecordLine, holds_length_and_checksum_that_other_programs_compute_alike) {
    // The check value of CRC-32 is that of the digits 1 to 9.
    EXPECT_EQ(record_line("123456789"), "{\"crc32\":\"cbf43926\",\"bytes\":9,\"record\":123456789}\n");
    EXPECT_EQ(record_line_bytes("123456789"), record_line("123456789").size());
    EXPECT_EQ(record_line_bytes(std::string(1000, 'x')), record_line(std::string(1000, 'x')).size());
}

TEST(RecordLine, lines_come_back_and_stop_at_the_first_that_is_none) {
    const std::vector<std::string> records{"{}", "{\"n\":1}", std::string(300, '7')};
    std::string text;
    for (const std::string& record : records) text += record_line(record);
    const RecordScan scan = scan_records(text);
    EXPECT_EQ(scan.end, End::whole);
    EXPECT_EQ(scan.whole_bytes, text.size());
    EXPECT_EQ(std::vector<std::string>(scan.records.begin(), scan.records.end()), records);
    EXPECT_EQ(scan_records("").records.size(), 0u);
    EXPECT_EQ(scan_records("hello").end, End::torn);
    EXPECT_EQ(scan_records("hello\nworld\n").end, End::damaged);
    EXPECT_EQ(scan_records("{\"crc32\":\"00000000\",\"bytes\":99999999999999999999,\"record\":}\n").end,
              End::damaged);
    EXPECT_EQ(scan_records("{\"crc32\":\"00000000\",\"bytes\":0000000,\"record\":}\n").end, End::damaged);
}

// Its record may have been acknowledged, so that it is not cut off in silence.
TEST(RecordLine, a_whole_record_with_another_end_is_damaged) {
    const std::string line = record_line("{\"n\":1}");
    for (const std::string end : {"}x", "]\n", "}\v", "}}\n", "x"}) {
        const std::string text = line + line.substr(0, line.size() - 2) + end;
        EXPECT_EQ(scan_records(text).end, End::damaged) << end;
        EXPECT_EQ(scan_records(text).records.size(), 1u);
    }
}

TEST(RecordLine, whatever_a_power_failure_leaves_of_the_last_line_is_torn) {
    const std::string first = record_line("{\"n\":0}"),
                      last = record_line("{\"n\":1,\"name\":\"a longer one\"}");
    for (std::size_t kept = 1; kept < last.size(); ++kept) {
        for (const bool with_zeros : {false, true}) {
            std::string text = first + last.substr(0, kept);
            if (with_zeros) text.resize(first.size() + last.size(), '\0');
            const RecordScan scan = scan_records(text);
            EXPECT_EQ(scan.end, End::torn) << kept;
            EXPECT_EQ(scan.records.size(), 1u);
            EXPECT_EQ(scan.whole_bytes, first.size());
        }
        // Pages of it were lost, and its end was not.
        std::string holed = first + last;
        for (std::size_t i = 0; i < std::min<std::size_t>(3, last.size() - 1 - kept); ++i)
            holed[first.size() + kept + i] = '\0';
        if (holed != first + last) {
            EXPECT_EQ(scan_records(holed).end, End::torn) << kept;
        }
    }
}

TEST(RecordLine, any_bit_that_changes_before_the_last_line_is_damage) {
    std::mt19937 random(1);
    std::string text;
    for (int n = 0; n < 5; ++n)
        text += record_line("{\"n\":" + std::to_string(n) + ",\"points\":[1.5,2.25,-3]}");
    const std::size_t last = text.rfind('{', text.size() - 40);
    for (std::size_t bit = 0; bit < 8 * last - 8; ++bit) {
        std::string changed = text;
        changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
        const RecordScan scan = scan_records(changed);
        EXPECT_EQ(scan.end, End::damaged) << bit;
        EXPECT_LE(scan.whole_bytes, bit / 8);
    }
}

}  // namespace
}  // namespace anatomesh::record_line_test
