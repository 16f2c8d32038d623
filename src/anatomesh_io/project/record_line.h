// Lines of a project file: each frames one record with its length and its checksum.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anatomesh {

// A longer record is refused, when it is written and when it is read: a parser takes several times its memory.
// [bytes; >= 2^20; B]
inline constexpr std::uint64_t most_record_bytes = std::uint64_t{1} << 28;

// Returns {"crc32":"89abcdef","bytes":123,"record":RECORD} and a line feed. The checksum is CRC-32 as in gzip (RFC 1952,
// section 8), of the bytes of the record. Requires: the record holds no line feed. O(n).
std::string record_line(std::string_view record);

// Returns the length of that line. O(1).
std::uint64_t record_line_bytes(std::string_view record);

// What the lines of a file hold, up to the first that is no line of ours.
struct RecordScan {
    enum class End : std::uint8_t {
        whole,  // every byte belongs to a line
        torn,  // the last line was not written to its end: it is unfinished, or holds zeros of a power failure
        damaged  // a line is not what was written
    };
    std::vector<std::string_view> records;  // of whole lines
    std::uint64_t whole_bytes = 0;          // of their lines
    End end = End::whole;
};

// O(n)
RecordScan scan_records(std::string_view text);

}  // namespace anatomesh
