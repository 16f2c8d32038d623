#include "anatomesh_io/dicom/pixels.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <utility>

#include "anatomesh_io/dicom/decoder.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

namespace {

Error pixel_error(const char* code, const DataSet& set, std::string message, std::string value,
                  std::string next_step) {
    return {ErrorKind::input,
            code,
            std::move(message),
            {set.name(), {}, {}, {}, std::move(value)},
            std::move(next_step)};
}

Error no_frames(const DataSet& set, std::size_t fragments, std::uint32_t frames) {
    return pixel_error("E-DCM-019", set,
                       "the fragments of the compressed pixels cannot be assigned to frames",
                       fmt::format("{} fragments, {} frames", fragments, frames), "export the file again");
}

// Parts the fragments at the offsets of the basic offset table, which count from the first fragment's item.
Result<std::vector<std::vector<std::string_view>>> by_offset_table(
    const DataSet& set, std::string_view table, std::span<const std::string_view> fragments,
    std::uint32_t frames) {
    std::vector<std::vector<std::string_view>> of_frame(frames);
    std::uint64_t at = 0;
    std::size_t frame = 0;
    const auto offset = [&](std::size_t i) {
        std::uint32_t value = 0;
        for (std::size_t b = 4; b-- > 0;) value = value << 8 | static_cast<unsigned char>(table[4 * i + b]);
        return value;
    };
    for (const std::string_view fragment : fragments) {
        if (frame < frames && at == offset(frame)) ++frame;
        if (frame == 0) return no_frames(set, fragments.size(), frames);
        of_frame[frame - 1].push_back(fragment);
        at += 8 + fragment.size();
    }
    if (frame != frames) return no_frames(set, fragments.size(), frames);
    return of_frame;
}

Result<std::vector<std::vector<std::string_view>>> frames_of(const DataSet& set,
                                                             std::vector<std::string_view> fragments,
                                                             std::uint32_t frames) {
    if (fragments.size() < 2) return no_frames(set, 0, frames);
    const std::string_view table = fragments[0];
    const std::span<const std::string_view> rest(fragments.data() + 1, fragments.size() - 1);
    std::vector<std::vector<std::string_view>> of_frame;
    if (frames == 1) {
        of_frame.emplace_back(rest.begin(), rest.end());
        return of_frame;
    }
    if (rest.size() == frames) {
        for (const std::string_view fragment : rest) of_frame.push_back({fragment});
        return of_frame;
    }
    if (rest.size() > frames && table.size() == std::size_t{4} * frames)
        return by_offset_table(set, table, rest, frames);
    return no_frames(set, rest.size(), frames);
}

template <class Unsigned, class Signed>
void normalize_values(std::span<std::byte> bytes, const PixelFormat& format, bool swap) {
    const unsigned shift = format.high_bit + 1 - format.bits_stored;
    const unsigned unused = sizeof(Unsigned) * 8 - format.bits_stored;
    if (shift == 0 && unused == 0 && !swap) return;
    for (std::size_t at = 0; at + sizeof(Unsigned) <= bytes.size(); at += sizeof(Unsigned)) {
        Unsigned value;
        std::memcpy(&value, bytes.data() + at, sizeof value);
        if (swap) value = byte_swapped(value);
        value = static_cast<Unsigned>(static_cast<Unsigned>(value >> shift) << unused);
        if (format.is_signed)
            value = static_cast<Unsigned>(static_cast<Signed>(value) >> unused);
        else
            value = static_cast<Unsigned>(value >> unused);
        std::memcpy(bytes.data() + at, &value, sizeof value);
    }
}

}  // namespace

std::size_t frame_bytes(const PixelFormat& format) {
    return static_cast<std::size_t>((format.frame_bits() + 7) / 8);
}

Result<PixelData> find_pixel_data(const DataSet& set, const PixelFormat& format, RunContext& context) {
    const DicomItem root = set.root();
    const DicomElement* element = root.find(tags::pixel_data);
    if (!element)
        return pixel_error("E-DCM-017", set, "the file holds no pixels", {}, "give the image files");
    PixelData data;
    const std::string& syntax = set.layout().transfer_syntax;
    const bool has_fragments = element->end > static_cast<std::uint32_t>(element - set.elements().data()) + 1;
    if (has_fragments || syntax.starts_with("1.2.840.10008.1.2.4.") || syntax == "1.2.840.10008.1.2.5") {
        if (!can_decode(syntax) || format.bits_allocated == 1)
            return pixel_error("E-DCM-020", set, "the program does not read this compression of pixels",
                               syntax.substr(0, 64), "decompress the series, for example with gdcmconv");
        data.is_compressed = true;
        ANATOMESH_TRY(data.fragments, frames_of(set, root.fragments(tags::pixel_data), format.frames));
        return data;
    }
    data.values = set.value(*element);
    // Below 2^16 x 2^16 x 32 x 10^6: no overflow.
    const std::uint64_t bits = format.frame_bits();
    if (bits > (std::uint64_t{1} << 62) / format.frames ||
        (bits * format.frames + 7) / 8 > data.values.size())
        return pixel_error("E-DCM-018", set, "the pixel data is shorter than the header states",
                           fmt::format("{} bytes for {} frames of {} x {} pixels", data.values.size(),
                                       format.frames, format.columns, format.rows),
                           "copy or export the file again");
    const std::uint64_t claimed = (bits * format.frames + 7) / 8;
    if (data.values.size() > claimed + claimed % 2)
        context.warn({"W-DCM-016",
                      "the file has bytes after its pixels",
                      {set.name(), {}, {}, {}, std::to_string(data.values.size() - claimed)},
                      "they were ignored"});
    data.values = data.values.substr(0, claimed);
    return data;
}

void normalize(std::span<std::byte> values, const PixelFormat& format, bool is_big_endian) {
    const bool swap = is_big_endian != (std::endian::native == std::endian::big);
    if (format.bits_allocated == 8) return normalize_values<std::uint8_t, std::int8_t>(values, format, false);
    if (format.bits_allocated == 16)
        return normalize_values<std::uint16_t, std::int16_t>(values, format, swap);
    return normalize_values<std::uint32_t, std::int32_t>(values, format, swap);
}

}  // namespace anatomesh
