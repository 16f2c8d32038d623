#include "anatomesh_io/project/record_line.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "anatomesh/base/number_text.h"

namespace anatomesh {

namespace {

constexpr std::string_view before_sum = R"({"crc32":")";
constexpr std::string_view before_size = R"(","bytes":)";
constexpr std::string_view before_record = R"(,"record":)";
constexpr std::string_view line_end = "}\n";
constexpr std::size_t sum_digits = 8;  // Of a checksum in hexadecimal. [digits; 8; D CRC-32]

std::string sum_of(std::string_view record) {
    const uLong sum = ::crc32_z(0, reinterpret_cast<const Bytef*>(record.data()), record.size());
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (int shift = 28; shift >= 0; shift -= 4) text += digits[(sum >> shift) & 15];
    return text;
}

bool skip(std::string_view& text, std::string_view part) {
    if (!text.starts_with(part)) return false;
    text.remove_prefix(part.size());
    return true;
}

// A record with its right checksum at the start of `text`, and what comes behind it: the end of its line, if it is whole.
struct FramedRecord {
    std::string_view record, behind;
};
std::optional<FramedRecord> framed_record(std::string_view text) {
    std::string_view rest = text;
    if (!skip(rest, before_sum) || rest.size() < sum_digits) return std::nullopt;
    const std::string_view sum = rest.substr(0, sum_digits);
    rest.remove_prefix(sum_digits);
    if (!skip(rest, before_size)) return std::nullopt;
    std::uint64_t size = 0;
    const auto [end, failure] = std::from_chars(rest.data(), rest.data() + rest.size(), size);
    if (failure != std::errc() || *rest.data() == '0' || size > most_record_bytes) return std::nullopt;
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    if (!skip(rest, before_record) || rest.size() < size) return std::nullopt;
    const std::string_view record = rest.substr(0, size);
    if (sum_of(record) != sum) return std::nullopt;
    return FramedRecord{record, rest.substr(static_cast<std::size_t>(size))};
}

// The record of a whole line at the start of `text`, which is moved behind it. Nothing where there is none.
std::optional<std::string_view> take_record(std::string_view& text) {
    std::optional<FramedRecord> framed = framed_record(text);
    if (!framed || !skip(framed->behind, line_end)) return std::nullopt;
    text = framed->behind;
    return framed->record;
}

// A record holds no line feed and no zero, and the next is begun only when this one is on the disk. So what is left of an
// unfinished line has no line feed, or the last one and zeros where data was lost.
bool is_torn(std::string_view rest) {
    // A whole record was perhaps acknowledged: an end that is neither a part of its own nor lost is damage.
    if (const auto framed = framed_record(rest)) {
        std::size_t n = 0;
        return std::all_of(framed->behind.begin(), framed->behind.end(), [&](char byte) {
            const std::size_t at = n++;
            return byte == '\0' || (at < line_end.size() && byte == line_end[at]);
        });
    }
    const std::size_t feed = rest.find('\n');
    return feed == std::string_view::npos ||
           (feed + 1 == rest.size() && rest.find('\0') != std::string_view::npos);
}

}  // namespace

std::string record_line(std::string_view record) {
    std::string line;
    line.reserve(static_cast<std::size_t>(record_line_bytes(record)));
    line += before_sum;
    line += sum_of(record);
    line += before_size;
    append_integer(line, record.size());
    line += before_record;
    line += record;
    line += line_end;
    return line;
}

std::uint64_t record_line_bytes(std::string_view record) {
    return before_sum.size() + sum_digits + before_size.size() + std::to_string(record.size()).size() +
           before_record.size() + record.size() + line_end.size();
}

RecordScan scan_records(std::string_view text) {
    RecordScan scan;
    std::string_view rest = text;
    while (const auto record = take_record(rest)) scan.records.push_back(*record);
    scan.whole_bytes = text.size() - rest.size();
    if (!rest.empty()) scan.end = is_torn(rest) ? RecordScan::End::torn : RecordScan::End::damaged;
    return scan;
}

}  // namespace anatomesh
