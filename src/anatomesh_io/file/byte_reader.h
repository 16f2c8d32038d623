// ByteReader: reads numbers and pieces of a byte buffer, and never beyond its end.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

namespace anatomesh {

// a * b, or nothing when that exceeds 64 bits. For sizes that a file claims.
std::optional<std::uint64_t> checked_multiply(std::uint64_t a, std::uint64_t b);

// `value` with its bytes in reverse order.
template <class T>
T byte_swapped(T value) {
    static_assert(std::is_arithmetic_v<T>);
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

// A view of bytes owned by the caller and a position in it.
// Guarantees: every read that would pass the end gives nothing and leaves the position where it was.
class ByteReader {
  public:
    explicit ByteReader(std::span<const std::byte> bytes, std::endian order = std::endian::little)
        : bytes_(bytes), order_(order) {}

    std::size_t size() const { return bytes_.size(); }
    std::size_t position() const { return position_; }
    std::size_t remaining() const { return bytes_.size() - position_; }
    std::endian order() const { return order_; }
    void set_order(std::endian order) { order_ = order; }

    // False, and no move, when the target lies beyond the end (the end itself is allowed).
    bool seek(std::uint64_t position);
    bool skip(std::uint64_t count);

    // The next sizeof(T) bytes as a number in the byte order of the reader.
    template <class T>
    std::optional<T> read() {
        static_assert(std::is_arithmetic_v<T>);
        if (remaining() < sizeof(T)) return std::nullopt;
        T value;
        std::memcpy(&value, bytes_.data() + position_, sizeof(T));
        position_ += sizeof(T);
        return order_ == std::endian::native ? value : byte_swapped(value);
    }

    std::optional<std::span<const std::byte>> read_bytes(std::uint64_t count);
    // The same bytes as text; stops nowhere but at `count` (zero bytes included).
    std::optional<std::string_view> read_text(std::uint64_t count);
    // Up to the next line feed, without it and without a carriage return before it; the last line may end at
    // the end of the buffer. Nothing at the end.
    std::optional<std::string_view> read_line();

  private:
    std::span<const std::byte> bytes_;
    std::size_t position_ = 0;
    std::endian order_;
};

inline std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace anatomesh
