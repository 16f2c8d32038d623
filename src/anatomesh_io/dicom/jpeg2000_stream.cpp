#include "anatomesh_io/dicom/jpeg2000_stream.h"

#include <algorithm>
#include <cstddef>

namespace anatomesh {

namespace {

// Of JPEG 2000. [code; 0xff30 to 0xffff; D ISO/IEC 15444-1, table A.2]
constexpr unsigned start_of_codestream = 0xff4f;
// Of JPEG 2000. [code; 0xff30 to 0xffff; D ISO/IEC 15444-1, table A.2]
constexpr unsigned image_size = 0xff51;
// Of JPEG 2000. [code; 0xff30 to 0xffff; D ISO/IEC 15444-1, table A.2]
constexpr unsigned coding_style = 0xff52;
// Of JPEG 2000. [code; 0xff30 to 0xffff; D ISO/IEC 15444-1, table A.2]
constexpr unsigned start_of_data = 0xff93;
constexpr std::string_view end_of_codestream("\xff\xd9", 2);
// Coded data has no run of zeros that is longer by itself. [bytes; >= 1; M 2026-11 longest of 20 CT slices and 20 drawn
// images: 9]
constexpr std::uint64_t longest_coded_run = 64;
// A header that states more packets is not believed. [packets; >= 1; B]
constexpr std::uint64_t most_packets = std::uint64_t{1} << 20;

// Big-endian numbers of a text, zero beyond its end.
std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t width) {
    std::uint64_t value = 0;
    for (std::size_t n = 0; n < width; ++n)
        value = value << 8 | (at + n < bytes.size() ? static_cast<unsigned char>(bytes[at + n]) : 0u);
    return value;
}

std::uint64_t ceiling(std::uint64_t value, std::uint64_t divisor) {
    return (value + divisor - 1) / divisor;
}

// What the main header says of a tile.
struct TileLayout {
    std::uint64_t width = 0, height = 0, components = 0;
    std::string_view style;  // the coding style's segment after its marker
};

// Of its packets: layers x components x precincts of all resolutions. A precinct more each way, since tiles need not
// begin at one.
std::uint64_t packets_of(const TileLayout& tile) {
    const std::uint64_t layers = number_at(tile.style, 4, 2), levels = number_at(tile.style, 7, 1);
    const bool has_sizes = number_at(tile.style, 2, 1) % 2 != 0;
    std::uint64_t precincts = 0;
    for (std::uint64_t resolution = 0; resolution <= std::min<std::uint64_t>(levels, 32); ++resolution) {
        const std::uint64_t size = has_sizes ? number_at(tile.style, 12 + resolution, 1) : 0xff;
        const std::uint64_t scale = std::uint64_t{1} << (std::min<std::uint64_t>(levels, 32) - resolution);
        precincts += (ceiling(ceiling(tile.width, scale), std::uint64_t{1} << size % 16) + 1) *
                     (ceiling(ceiling(tile.height, scale), std::uint64_t{1} << size / 16) + 1);
        precincts = std::min(precincts, most_packets);
    }
    return std::min(layers * std::min(tile.components * precincts, most_packets), most_packets);
}

// Where the coded data begins, and the packets of a tile.
struct CodedData {
    std::size_t first = 0;
    std::uint64_t packets = 0;
};

std::optional<CodedData> coded_data(std::string_view stream) {
    if (number_at(stream, 0, 2) != start_of_codestream) return std::nullopt;
    TileLayout tile;
    for (std::size_t at = 2; at + 4 <= stream.size();) {
        const std::uint64_t marker = number_at(stream, at, 2), length = number_at(stream, at + 2, 2);
        if (marker == start_of_data) {
            if (tile.components == 0 || tile.style.empty()) return std::nullopt;
            return CodedData{at + 2, packets_of(tile)};
        }
        const std::string_view segment = stream.substr(at + 2, length);
        if (marker == image_size) {
            tile.width = std::min(number_at(segment, 4, 4), number_at(segment, 20, 4));
            tile.height = std::min(number_at(segment, 8, 4), number_at(segment, 24, 4));
            tile.components = number_at(segment, 36, 2);
        } else if (marker == coding_style) {
            tile.style = segment;
        }
        at += 2 + std::max<std::size_t>(length, 2);
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> zeroed_stretch(std::string_view codestream) {
    const std::optional<CodedData> data = coded_data(codestream);
    if (!data) return std::nullopt;
    // What follows the end is padding.
    const std::size_t end = codestream.rfind(end_of_codestream);
    std::uint64_t run = 0, longest = 0;
    for (std::size_t at = data->first; at < std::min(end, codestream.size()); ++at) {
        run = codestream[at] == 0 ? run + 1 : 0;
        longest = std::max(longest, run);
    }
    if (longest <= data->packets + longest_coded_run) return std::nullopt;
    return longest;
}

}  // namespace anatomesh
