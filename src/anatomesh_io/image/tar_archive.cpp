#include "anatomesh_io/image/tar_archive.h"

#include <fmt/format.h>

#include <optional>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

// A tar archive consists of blocks of this size. [bytes; 512; D POSIX ustar]
constexpr std::size_t block = 512;
// An archive with more entries is refused, before they take all memory. [entries; >= 1; B]
constexpr std::size_t most_entries = 100000;

// Octal digits between blanks and zero bytes, or GNU's binary form for large sizes.
std::optional<std::uint64_t> tar_number(std::string_view field) {
    if (!field.empty() && (static_cast<unsigned char>(field.front()) & 0x80) != 0) {
        std::uint64_t value = static_cast<unsigned char>(field.front()) & 0x7fU;
        for (const char c : field.substr(1)) {
            if (value >> 55 != 0) return std::nullopt;
            value = value << 8 | static_cast<unsigned char>(c);
        }
        return value;
    }
    std::uint64_t value = 0;
    bool any = false;
    for (const char c : field) {
        if (c == '\0' || (c == ' ' && any)) break;
        if (c == ' ') continue;
        if (c < '0' || c > '7') return std::nullopt;
        value = value << 3 | static_cast<std::uint64_t>(c - '0');  // at most 12 digits: 36 bits
        any = true;
    }
    return any ? std::optional(value) : std::nullopt;
}

// The sum of the header's bytes with the checksum field read as blanks.
bool checksum_holds(std::string_view header) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < block; ++i)
        sum += i >= 148 && i < 156 ? ' ' : static_cast<unsigned char>(header[i]);
    return tar_number(header.substr(148, 8)) == sum;
}

}  // namespace

Result<std::vector<TarEntry>> tar_entries(std::span<const std::byte> archive, const std::string& path) {
    std::vector<TarEntry> entries;
    ByteReader reader(archive);
    for (std::size_t count = 0;; ++count) {
        const auto header = reader.read_text(block);
        // Archives end with two zero blocks; a missing end is tolerated, a torn header is not.
        if (!header && reader.remaining() == 0) return entries;
        if (header && header->find_first_not_of('\0') == std::string_view::npos) return entries;
        const auto size = header ? tar_number(header->substr(124, 12)) : std::nullopt;
        if (!size || !checksum_holds(*header))
            return image_error("E-INV-001",
                               fmt::format("the archive is damaged at byte {}", reader.position()), path, "",
                               "save the project again");
        if (count == most_entries)
            return image_error("E-INV-003", fmt::format("the archive has more than {} entries", most_entries),
                               path, "", "this is no InVesalius project");
        const std::string_view name = header->substr(0, std::min(header->find('\0'), std::size_t{100}));
        const auto content = reader.read_bytes(*size);
        if (!content)
            return image_error(
                "E-INV-002",
                fmt::format("an entry announces {} bytes, but {} are left", *size, reader.remaining()), path,
                shown(name), "copy or save the project again");
        const char kind = (*header)[156];
        if (kind == '0' || kind == '\0') entries.push_back({name, *content});
        // Content is padded to whole blocks; the last may be cut.
        reader.skip(std::min<std::uint64_t>((block - *size % block) % block, reader.remaining()));
    }
}

}  // namespace anatomesh
