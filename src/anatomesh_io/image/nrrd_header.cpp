#include "anatomesh_io/image/nrrd_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

namespace {

// A longer header is refused, before it takes all memory. [bytes; >= 4096; B]
constexpr std::size_t longest_header = std::size_t{16} << 20;
// A file with more axes is refused, as by the format's own library. [axes; 16; D NRRD]
constexpr std::uint64_t most_axes = 16;

using Fields = std::map<std::string, std::string, std::less<>>;

// Fields that say nothing about values or places.
constexpr std::array<std::string_view, 24> idle_fields = {
    "content",    "number",          "sample units",      "units",    "labels",    "kinds",    "centers",
    "centerings", "thicknesses",     "measurement frame", "min",      "max",       "old min",  "old max",
    "oldmin",     "oldmax",          "axis mins",         "axismins", "axis maxs", "axismaxs", "block size",
    "blocksize",  "space dimension", "space units"};
constexpr std::array<std::string_view, 11> used_fields = {
    "type",     "dimension",        "sizes",        "endian",    "encoding", "space",
    "spacings", "space directions", "space origin", "data file", "line skip"};

// Old spellings of the same field.
std::string canonical(std::string name) {
    if (name == "datafile") return "data file";
    if (name == "lineskip") return "line skip";
    if (name == "byteskip") return "byte skip";
    return name;
}

bool is_known(std::string_view name) {
    return name == "byte skip" ||
           std::find(idle_fields.begin(), idle_fields.end(), name) != idle_fields.end() ||
           std::find(used_fields.begin(), used_fields.end(), name) != used_fields.end();
}

Error field_error(const char* code, const std::string& message, const std::string& path,
                  std::string_view value) {
    return image_error(code, message, path, shown(value), "correct the header of the image");
}

Error bad_value(std::string_view field, const std::string& path, std::string_view value) {
    return field_error("E-NRD-005", fmt::format("the field '{}' has an impossible value", field), path,
                       value);
}

// Sorts the header's lines into fields and key/value pairs; sets data_begin.
Result<Fields> read_lines(std::span<const std::byte> bytes, const std::string& path, RunContext& context,
                          NrrdHeader& header) {
    ByteReader reader(bytes.first(std::min(bytes.size(), longest_header)));
    Fields fields;
    const auto magic = reader.read_line();
    if (!magic || magic->size() != 8 || !magic->starts_with("NRRD000") || (*magic)[7] < '1' ||
        (*magic)[7] > '5')
        return field_error("E-NRD-001", "the file is no NRRD file of version 1 to 5", path,
                           magic.value_or(""));
    while (const auto line = reader.read_line()) {
        header.data_begin = reader.position();
        if (line->empty()) break;
        if (line->front() == '#') continue;
        const std::size_t colon = line->find(':');
        if (colon == std::string_view::npos || colon == 0)
            return field_error("E-NRD-002", "a line of the header is neither a field nor a comment", path,
                               *line);
        if (line->substr(colon).starts_with(":=")) {
            header.pairs.emplace_back(line->substr(0, colon), trimmed(line->substr(colon + 2)));
            continue;
        }
        const std::string name = canonical(lower_case(trimmed(line->substr(0, colon))));
        const std::string value(trimmed(line->substr(colon + 1)));
        const auto [at, inserted] = fields.emplace(name, value);
        if (!inserted && at->second != value)
            return field_error("E-NRD-003",
                               fmt::format("the field '{}' occurs twice with different values", shown(name)),
                               path, value);
        // The names of a list of files follow instead of the rest of the header; the list is refused later.
        if (name == "data file" && value.starts_with("LIST")) break;
        if (inserted && !is_known(name))
            context.warn(image_warning("W-NRD-001", fmt::format("the field '{}' is unknown", shown(name)),
                                       path, shown(value), "it was ignored"));
    }
    if (reader.remaining() == 0 && bytes.size() > longest_header && header.data_begin >= longest_header)
        return field_error("E-NRD-002", "the header is longer than 16 MiB", path, "");
    return fields;
}

Result<std::string> needed(const Fields& fields, const char* name, const std::string& path) {
    const auto found = fields.find(name);
    if (found == fields.end() || found->second.empty())
        return field_error("E-NRD-004", fmt::format("the field '{}' is missing", name), path, "");
    return found->second;
}

std::string_view value_or_empty(const Fields& fields, std::string_view name) {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string_view() : std::string_view(found->second);
}

Status read_type(const Fields& fields, const std::string& path, NrrdHeader& header) {
    static const std::map<std::string, VoxelType, std::less<>> names = {
        {"signed char", VoxelType::i8},
        {"int8", VoxelType::i8},
        {"int8_t", VoxelType::i8},
        {"uchar", VoxelType::u8},
        {"unsigned char", VoxelType::u8},
        {"uint8", VoxelType::u8},
        {"uint8_t", VoxelType::u8},
        {"short", VoxelType::i16},
        {"short int", VoxelType::i16},
        {"signed short", VoxelType::i16},
        {"signed short int", VoxelType::i16},
        {"int16", VoxelType::i16},
        {"int16_t", VoxelType::i16},
        {"ushort", VoxelType::u16},
        {"unsigned short", VoxelType::u16},
        {"unsigned short int", VoxelType::u16},
        {"uint16", VoxelType::u16},
        {"uint16_t", VoxelType::u16},
        {"int", VoxelType::i32},
        {"signed int", VoxelType::i32},
        {"int32", VoxelType::i32},
        {"int32_t", VoxelType::i32},
        {"uint", VoxelType::u32},
        {"unsigned int", VoxelType::u32},
        {"uint32", VoxelType::u32},
        {"uint32_t", VoxelType::u32},
        {"longlong", VoxelType::i64},
        {"long long", VoxelType::i64},
        {"long long int", VoxelType::i64},
        {"signed long long", VoxelType::i64},
        {"signed long long int", VoxelType::i64},
        {"int64", VoxelType::i64},
        {"int64_t", VoxelType::i64},
        {"ulonglong", VoxelType::u64},
        {"unsigned long long", VoxelType::u64},
        {"unsigned long long int", VoxelType::u64},
        {"uint64", VoxelType::u64},
        {"uint64_t", VoxelType::u64},
        {"float", VoxelType::f32},
        {"double", VoxelType::f64}};
    ANATOMESH_TRY(const std::string value, needed(fields, "type", path));
    const auto found = names.find(lower_case(value));
    if (found == names.end())
        return field_error("E-NRD-006", "voxels of this type are not supported", path, value);
    header.type = found->second;
    return Nothing{};
}

Status read_encoding(const Fields& fields, const std::string& path, NrrdHeader& header) {
    ANATOMESH_TRY(const std::string value, needed(fields, "encoding", path));
    const std::string name = lower_case(value);
    if (name == "raw")
        header.encoding = NrrdEncoding::raw;
    else if (name == "gzip" || name == "gz")
        header.encoding = NrrdEncoding::gzip;
    else if (name == "ascii" || name == "text" || name == "txt")
        header.encoding = NrrdEncoding::text;
    else
        return image_error("E-NRD-007", "this encoding is not supported", path, shown(value),
                           "save the image with encoding raw or gzip");
    const std::string_view endian = value_or_empty(fields, "endian");
    if (lower_case(endian) == "little")
        header.order = std::endian::little;
    else if (lower_case(endian) == "big")
        header.order = std::endian::big;
    else if (!endian.empty())
        return bad_value("endian", path, endian);
    else if (header.encoding != NrrdEncoding::text && byte_size(header.type) > 1)
        return field_error("E-NRD-004", "the field 'endian' is missing", path, "");
    return Nothing{};
}

Status read_sizes(const Fields& fields, const std::string& path, NrrdHeader& header) {
    ANATOMESH_TRY(const std::string dimension, needed(fields, "dimension", path));
    const auto axes = parse_integer(dimension);
    if (!axes || *axes < 1 || static_cast<std::uint64_t>(*axes) > most_axes)
        return bad_value("dimension", path, dimension);
    ANATOMESH_TRY(const std::string value, needed(fields, "sizes", path));
    for (const std::string_view word : words(value)) {
        const auto size = parse_integer(word);
        if (!size || *size < 1) return bad_value("sizes", path, value);
        header.sizes.push_back(static_cast<std::uint64_t>(*size));
        if (header.sizes.size() > most_axes) break;
    }
    if (header.sizes.size() != static_cast<std::size_t>(*axes)) return bad_value("sizes", path, value);
    return Nothing{};
}

// "(a,b,c)" at the start of the text, which is shortened by it; blanks around numbers are allowed.
std::optional<Vec3> take_vector(std::string_view& text) {
    const std::size_t end = text.find(')');
    if (!text.starts_with("(") || end == std::string_view::npos) return std::nullopt;
    std::string_view inner = text.substr(1, end - 1);
    text.remove_prefix(end + 1);
    std::array<double, 3> numbers{};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t comma = inner.find(',');
        if ((comma == std::string_view::npos) != (i == 2)) return std::nullopt;
        const auto number = parse_double(trimmed(inner.substr(0, comma)));
        if (!number || !std::isfinite(*number)) return std::nullopt;
        numbers[i] = *number;
        if (i < 2) inner.remove_prefix(comma + 1);
    }
    return Vec3{numbers[0], numbers[1], numbers[2]};
}

Status read_directions(const Fields& fields, const std::string& path, NrrdHeader& header) {
    const std::string_view value = value_or_empty(fields, "space directions");
    std::string_view rest = trimmed(value);
    while (!rest.empty()) {
        if (rest.starts_with("none")) {
            header.directions.emplace_back(std::nullopt);
            rest.remove_prefix(4);
        } else {
            const auto vector = take_vector(rest);
            if (!vector) return bad_value("space directions", path, value);
            header.directions.emplace_back(*vector);
        }
        if (header.directions.size() > header.sizes.size()) return bad_value("space directions", path, value);
        rest = trimmed(rest);
    }
    if (!header.directions.empty() && header.directions.size() != header.sizes.size())
        return bad_value("space directions", path, value);

    const std::string_view origin = value_or_empty(fields, "space origin");
    if (!origin.empty()) {
        std::string_view text = origin;
        header.origin = take_vector(text);
        if (!header.origin || !trimmed(text).empty()) return bad_value("space origin", path, origin);
    }
    const std::string_view spacings = value_or_empty(fields, "spacings");
    for (const std::string_view word : words(spacings)) {
        // "nan" marks an axis that is not spatial.
        const auto spacing = parse_double(word);
        if (!spacing || std::isinf(*spacing)) return bad_value("spacings", path, spacings);
        header.spacings.push_back(*spacing);
        if (header.spacings.size() > header.sizes.size()) break;
    }
    if (!header.spacings.empty() && header.spacings.size() != header.sizes.size())
        return bad_value("spacings", path, spacings);
    return Nothing{};
}

// "mm" "mm" "mm"; the file's unit must be one and the same along all axes.
Status read_unit(const Fields& fields, const std::string& path, RunContext& context, NrrdHeader& header) {
    const std::string_view value = value_or_empty(fields, "space units");
    std::string first;
    for (const std::string_view word : words(value)) {
        std::string unit(word);
        std::erase(unit, '"');
        if (first.empty()) first = unit;
        if (unit != first) return bad_value("space units", path, value);
    }
    if (first.empty() || first == "mm")
        header.millimetres = 1;
    else if (first == "m")
        header.millimetres = 1000;
    else if (first == "cm")
        header.millimetres = 10;
    else if (first == "um" || first == "\xc2\xb5m" || first == "micron" || first == "microns")
        header.millimetres = 0.001;
    else
        context.warn(image_warning("W-NRD-002", "the unit of the space is not known", path, shown(value),
                                   "millimetres were assumed"));
    return Nothing{};
}

Status read_data_place(const Fields& fields, const std::string& path, NrrdHeader& header) {
    header.data_file = value_or_empty(fields, "data file");
    if (const std::string_view value = value_or_empty(fields, "line skip"); !value.empty()) {
        const auto skip = parse_integer(value);
        if (!skip || *skip < 0) return bad_value("line skip", path, value);
        header.line_skip = static_cast<std::uint64_t>(*skip);
    }
    if (const std::string_view value = value_or_empty(fields, "byte skip"); !value.empty()) {
        const auto skip = parse_integer(value);
        if (!skip || *skip < -1 || (*skip == -1 && header.encoding != NrrdEncoding::raw))
            return bad_value("byte skip", path, value);
        header.byte_skip = *skip;
    }
    return Nothing{};
}

}  // namespace

Result<NrrdHeader> parse_nrrd_header(std::span<const std::byte> bytes, const std::string& path,
                                     RunContext& context) {
    NrrdHeader header;
    ANATOMESH_TRY(const Fields fields, read_lines(bytes, path, context, header));
    ANATOMESH_CHECK_STATUS(read_type(fields, path, header));
    ANATOMESH_CHECK_STATUS(read_encoding(fields, path, header));
    ANATOMESH_CHECK_STATUS(read_sizes(fields, path, header));
    ANATOMESH_CHECK_STATUS(read_directions(fields, path, header));
    ANATOMESH_CHECK_STATUS(read_unit(fields, path, context, header));
    ANATOMESH_CHECK_STATUS(read_data_place(fields, path, header));
    header.space = lower_case(value_or_empty(fields, "space"));
    return header;
}

}  // namespace anatomesh
