#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

std::optional<std::uint64_t> checked_multiply(std::uint64_t a, std::uint64_t b) {
    std::uint64_t product = 0;
    if (__builtin_mul_overflow(a, b, &product)) return std::nullopt;
    return product;
}

bool ByteReader::seek(std::uint64_t position) {
    if (position > bytes_.size()) return false;
    position_ = static_cast<std::size_t>(position);
    return true;
}

bool ByteReader::skip(std::uint64_t count) {
    if (count > remaining()) return false;
    position_ += static_cast<std::size_t>(count);
    return true;
}

std::optional<std::span<const std::byte>> ByteReader::read_bytes(std::uint64_t count) {
    if (count > remaining()) return std::nullopt;
    const auto piece = bytes_.subspan(position_, static_cast<std::size_t>(count));
    position_ += piece.size();
    return piece;
}

std::optional<std::string_view> ByteReader::read_text(std::uint64_t count) {
    const auto piece = read_bytes(count);
    if (!piece) return std::nullopt;
    return as_text(*piece);
}

std::optional<std::string_view> ByteReader::read_line() {
    if (remaining() == 0) return std::nullopt;
    std::string_view rest = as_text(bytes_.subspan(position_));
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) {
        position_ = bytes_.size();
    } else {
        position_ += end + 1;
        rest = rest.substr(0, end);
    }
    if (!rest.empty() && rest.back() == '\r') rest.remove_suffix(1);
    return rest;
}

}  // namespace anatomesh
