#include "anatomesh_io/mesh/vtk_decode.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>
#include <optional>

namespace anatomesh {

namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\n' || c == '\t' || c == '\r';
}

// A stream of bytes, as they are or in base64. VTK pads the header and the data of an array separately,
// others encode both together: after padding this stream simply goes on with the next group.
class ByteStream {
  public:
    ByteStream(std::string_view text, bool base64) : text_(text), base64_(base64) {}

    // No more than this many bytes can follow.
    std::uint64_t at_most() const { return base64_ ? text_.size() / 4 * 3 + pending_ : text_.size(); }

    bool read(char* out, std::size_t count) {
        if (!base64_) {
            if (text_.size() < count) return false;
            std::copy_n(text_.data(), count, out);
            text_.remove_prefix(count);
            return true;
        }
        while (count > 0) {
            if (pending_ == 0 && !next_group()) return false;
            *out++ = group_[group_size_ - pending_--];
            --count;
        }
        return true;
    }

  private:
    static int digit(char c) {
        if (c >= 'A' && c <= 'Z') return c - 'A';
        if (c >= 'a' && c <= 'z') return c - 'a' + 26;
        if (c >= '0' && c <= '9') return c - '0' + 52;
        return c == '+' ? 62 : c == '/' ? 63 : -1;
    }

    bool next_group() {
        std::uint32_t bits = 0;
        int digits = 0, padding = 0;
        while (digits + padding < 4) {
            while (!text_.empty() && is_blank(text_.front())) text_.remove_prefix(1);
            if (text_.empty()) return false;
            const char c = text_.front();
            const int value = digit(c);
            if (c == '=' && digits >= 2) {
                ++padding;
            } else if (value >= 0 && padding == 0) {
                ++digits;
            } else {
                return false;
            }
            bits = bits << 6 | static_cast<std::uint32_t>(value >= 0 ? value : 0);
            text_.remove_prefix(1);
        }
        for (int i = 0; i < 3; ++i) group_[i] = static_cast<char>(bits >> (16 - 8 * i) & 0xFF);
        group_size_ = pending_ = static_cast<unsigned>(digits - 1);
        return true;
    }

    std::string_view text_;
    bool base64_;
    char group_[3] = {};
    unsigned group_size_ = 0, pending_ = 0;
};

std::optional<std::uint64_t> read_word(ByteStream& stream, const VtkEncoding& encoding) {
    char bytes[8] = {};
    const std::size_t size = encoding.wide_header ? 8 : 4;
    if (!stream.read(bytes, size)) return std::nullopt;
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t place = encoding.little_endian ? i : size - 1 - i;
        word |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[i])) << 8 * place;
    }
    return word;
}

Error ends_early(const VtkArray& array, const VtkEncoding& encoding) {
    return vtk_error("E-VTK-004", "the array ends too early", encoding.path, array.name);
}

Status read_plain(VtkArray& array, ByteStream& stream, const VtkEncoding& encoding, std::uint64_t& inflated) {
    const auto size = read_word(stream, encoding);
    if (!size || *size > stream.at_most()) return ends_early(array, encoding);
    array.bytes.resize(*size);
    inflated += *size;
    if (!stream.read(array.bytes.data(), array.bytes.size())) return ends_early(array, encoding);
    return Nothing{};
}

struct Blocks {
    std::vector<std::uint64_t> packed_sizes;
    std::uint64_t block = 0, last = 0;  // bytes of a block, of the last one
    std::uint64_t packed = 0, total = 0;
};

// The header of a compressed array: [blocks, bytes of a block, bytes of a part at the end, packed sizes ...].
// Every number is held against the bytes that are there before anything is allocated by it.
Result<Blocks> read_blocks(const VtkArray& array, ByteStream& stream, const VtkEncoding& encoding) {
    // zlib cannot pack better, so a block that claims more is damaged. [1; 1032; D zlib]
    constexpr std::uint64_t best_ratio = 1032;
    // A block may claim so much more, because a stream ends in the middle of a byte. [bytes; >= 1; D zlib]
    constexpr std::uint64_t small_block = 64;
    const auto count = read_word(stream, encoding), block = read_word(stream, encoding),
               part = read_word(stream, encoding);
    if (!count || !block || !part || *count > stream.at_most()) return ends_early(array, encoding);
    const Error damaged = vtk_error("E-VTK-005", "the sizes of the compressed blocks are impossible",
                                    encoding.path, array.name);
    Blocks blocks;
    blocks.block = *block;
    blocks.last = *part == 0 ? *block : *part;
    if (blocks.last > blocks.block) return damaged;
    for (std::uint64_t i = 0; i < *count; ++i) {
        const auto packed = read_word(stream, encoding);
        if (!packed || *packed > stream.at_most()) return ends_early(array, encoding);
        const std::uint64_t full = i + 1 == *count ? blocks.last : blocks.block;
        if (full > *packed * best_ratio + small_block) return damaged;
        blocks.packed += *packed;
        blocks.total += full;
        blocks.packed_sizes.push_back(*packed);
    }
    if (blocks.packed > stream.at_most()) return ends_early(array, encoding);
    return blocks;
}

Status read_compressed(VtkArray& array, ByteStream& stream, const VtkEncoding& encoding,
                       std::uint64_t& inflated) {
    ANATOMESH_TRY(const Blocks blocks, read_blocks(array, stream, encoding));
    inflated += blocks.total;
    const InputLimits& limits = encoding.limits;
    // Over the whole file: single arrays of one value are packed far better than the ratio.
    const bool bomb =
        inflated > limits.free_inflated_bytes && inflated / limits.max_inflate_ratio > encoding.file_bytes;
    if (bomb || inflated > limits.max_inflated_bytes) {
        Error error = vtk_error("E-VTK-010",
                                "the array would expand from " + std::to_string(blocks.packed) + " to " +
                                    std::to_string(blocks.total) + " bytes, beyond the limit",
                                encoding.path, array.name);
        error.kind = ErrorKind::limit;
        return error;
    }
    array.bytes.resize(blocks.total);
    std::string packed;
    std::size_t at = 0;
    for (std::size_t i = 0; i < blocks.packed_sizes.size(); ++i) {
        packed.resize(blocks.packed_sizes[i]);
        if (!stream.read(packed.data(), packed.size())) return ends_early(array, encoding);
        const std::uint64_t full = i + 1 == blocks.packed_sizes.size() ? blocks.last : blocks.block;
        uLongf size = full;
        const int status = uncompress(reinterpret_cast<Bytef*>(array.bytes.data() + at), &size,
                                      reinterpret_cast<const Bytef*>(packed.data()), packed.size());
        if (status != Z_OK || size != full) {
            return vtk_error("E-VTK-005", "compressed block " + std::to_string(i) + " is damaged",
                             encoding.path, array.name);
        }
        at += full;
    }
    return Nothing{};
}

void swap_bytes(VtkArray& array) {
    const std::size_t size = byte_size(array.type);
    for (std::size_t at = 0; at + size <= array.bytes.size(); at += size) {
        std::reverse(array.bytes.begin() + static_cast<std::ptrdiff_t>(at),
                     array.bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
    }
}

// Appends every number of the text; the first token that is none is given back.
template <class T>
std::optional<std::string> parse_numbers(std::string_view text, std::string& bytes) {
    const char* at = text.data();
    const char* const end = at + text.size();
    for (;;) {
        while (at != end && is_blank(*at)) ++at;
        if (at == end) return std::nullopt;
        T value{};
        const auto [stop, failure] = std::from_chars(at, end, value);
        if (failure != std::errc() || (stop != end && !is_blank(*stop))) {
            return std::string(at, std::find_if(at, std::min(end, at + 40), is_blank));
        }
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
        at = stop;
    }
}

// Characters as numbers, signed or not.
std::optional<std::string> parse_characters(std::string_view text, std::string& bytes) {
    std::string numbers;
    if (auto bad = parse_numbers<std::int16_t>(text, numbers)) return bad;
    for (std::size_t at = 0; at < numbers.size(); at += sizeof(std::int16_t)) {
        std::int16_t number = 0;
        std::memcpy(&number, numbers.data() + at, sizeof number);
        if (number < -128 || number > 255) return std::to_string(number);
        bytes.push_back(static_cast<char>(number & 0xFF));
    }
    return std::nullopt;
}

std::optional<std::string> parse_numbers(VtkArray& array, std::string_view text) {
    switch (array.type) {
        case VtkType::int8:
            return parse_numbers<std::int8_t>(text, array.bytes);
        case VtkType::uint8:
            return parse_numbers<std::uint8_t>(text, array.bytes);
        case VtkType::string:
            return parse_characters(text, array.bytes);
        case VtkType::int16:
            return parse_numbers<std::int16_t>(text, array.bytes);
        case VtkType::uint16:
            return parse_numbers<std::uint16_t>(text, array.bytes);
        case VtkType::int32:
            return parse_numbers<std::int32_t>(text, array.bytes);
        case VtkType::uint32:
            return parse_numbers<std::uint32_t>(text, array.bytes);
        case VtkType::int64:
            return parse_numbers<std::int64_t>(text, array.bytes);
        case VtkType::uint64:
            return parse_numbers<std::uint64_t>(text, array.bytes);
        case VtkType::float32:
            return parse_numbers<float>(text, array.bytes);
        case VtkType::float64:
            return parse_numbers<double>(text, array.bytes);
    }
    return std::nullopt;
}

}  // namespace

Error vtk_error(const char* code, std::string message, const std::string& path, const std::string& array) {
    if (!array.empty()) message += " (array " + array + ")";
    Error error{ErrorKind::input, code, std::move(message), {}, "write the file again"};
    error.place.file = path;
    return error;
}

Status decode_ascii(VtkArray& array, std::string_view text, const VtkEncoding& encoding) {
    if (const auto bad = parse_numbers(array, text)) {
        Error error =
            vtk_error("E-VTK-004", "the array holds a word that is not a number", encoding.path, array.name);
        error.place.value = *bad;
        return error;
    }
    return Nothing{};
}

Status decode_binary(VtkArray& array, std::string_view data, bool base64, const VtkEncoding& encoding,
                     std::uint64_t& inflated) {
    ByteStream stream(data, base64);
    if (encoding.compressed) {
        ANATOMESH_CHECK_STATUS(read_compressed(array, stream, encoding, inflated));
    } else {
        ANATOMESH_CHECK_STATUS(read_plain(array, stream, encoding, inflated));
    }
    if (encoding.little_endian != (std::endian::native == std::endian::little)) swap_bytes(array);
    return Nothing{};
}

}  // namespace anatomesh
