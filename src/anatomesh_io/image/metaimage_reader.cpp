// MetaImage: a text header "Key = Value", and data behind it or in a file of its own.
//
// Errors (input): E-MTI-001 the header is not readable, -002 a needed key is missing, -003 the value of a key
// is not usable, -004 a key is repeated with another value, -005 not an image of numbers, -006 voxel type not
// supported. Warns: W-MTI-001 unknown key ignored, W-MTI-002 position or direction missing, W-MTI-003
// AnatomicalOrientation contradicts the transform's convention.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/raw_image.h"
#include "anatomesh_io/image/tracked_frames.h"

namespace anatomesh {

namespace {

// A longer header is refused, before it takes all memory. [bytes; >= 4096; B]
constexpr std::size_t longest_meta_header = std::size_t{16} << 20;

using Keys = std::map<std::string, std::string, std::less<>>;

Error key_error(const char* code, const std::string& message, const std::string& path,
                std::string_view value) {
    return image_error(code, message, path, shown(value), "correct the header of the image");
}

Error bad_meta_value(std::string_view key, const std::string& path, std::string_view value) {
    return key_error("E-MTI-003", fmt::format("the key {} has an impossible value", key), path, value);
}

// Several keys have more than one name.
std::string canonical_meta_key(std::string_view key) {
    if (key == "Position" || key == "Origin") return "Offset";
    if (key == "Rotation" || key == "Orientation") return "TransformMatrix";
    if (key == "BinaryDataByteOrderMSB") return "ElementByteOrderMSB";
    return std::string(key);
}

bool is_known_meta_key(std::string_view key) {
    constexpr std::array<std::string_view, 30> known = {"ObjectType",
                                                        "NDims",
                                                        "BinaryData",
                                                        "ElementByteOrderMSB",
                                                        "CompressedData",
                                                        "CompressedDataSize",
                                                        "TransformMatrix",
                                                        "Offset",
                                                        "CenterOfRotation",
                                                        "AnatomicalOrientation",
                                                        "ElementSpacing",
                                                        "DimSize",
                                                        "ElementType",
                                                        "ElementDataFile",
                                                        "ElementNumberOfChannels",
                                                        "HeaderSize",
                                                        "ElementSize",
                                                        "Modality",
                                                        "DistanceUnits",
                                                        "Comment",
                                                        "ObjectSubType",
                                                        "TransformType",
                                                        "Name",
                                                        "ID",
                                                        "ParentID",
                                                        "Color",
                                                        "AcquisitionDate",
                                                        "ElementMin",
                                                        "ElementMax",
                                                        "Kinds"};
    return std::find(known.begin(), known.end(), key) != known.end();
}

struct Header {
    Keys keys;
    KeyValues sequence;  // those of tracked sequences
    std::size_t data_begin = 0;

    std::string_view get(std::string_view key) const {
        const auto found = keys.find(key);
        return found == keys.end() ? std::string_view() : std::string_view(found->second);
    }
    bool has(std::string_view key) const { return keys.find(key) != keys.end(); }
};

// ElementDataFile is the last key; the data may begin right behind its line.
Result<Header> parse_header(std::span<const std::byte> content, const std::string& path,
                            RunContext& context) {
    ByteReader reader(content.first(std::min(content.size(), longest_meta_header)));
    Header header;
    std::size_t unknown = 0;
    std::string first_unknown;
    while (const auto line = reader.read_line()) {
        if (trimmed(*line).empty()) continue;
        const std::size_t equals = line->find('=');
        if (equals == std::string_view::npos)
            return key_error("E-MTI-001", "a line of the header is not of the form Key = Value", path, *line);
        const std::string key = canonical_meta_key(trimmed(line->substr(0, equals)));
        const std::string value(trimmed(line->substr(equals + 1)));
        const auto [at, inserted] = header.keys.emplace(key, value);
        if (!inserted && at->second != value)
            return key_error("E-MTI-004",
                             fmt::format("the key {} occurs twice with different values", shown(key)), path,
                             value);
        if (key.starts_with("Seq_") || key.ends_with("Transform") || key.starts_with("UltrasoundImage")) {
            if (inserted) header.sequence.emplace_back(key, value);
        } else if (inserted && !is_known_meta_key(key) && unknown++ == 0) {
            first_unknown = key;
        }
        if (key == "ElementDataFile") {
            header.data_begin = reader.position();
            if (unknown > 0)
                context.warn(image_warning("W-MTI-001",
                                           fmt::format("the header has {} unknown keys, and the first is {}",
                                                       unknown, shown(first_unknown)),
                                           path, shown(first_unknown), "they were ignored"));
            return header;
        }
    }
    return key_error("E-MTI-002", "the key ElementDataFile is missing", path, "");
}

Result<bool> boolean(const Header& header, const char* key, bool otherwise, const std::string& path) {
    if (!header.has(key)) return otherwise;
    const std::string value = lower_case(header.get(key));
    if (value == "true" || value == "1" || value == "t") return true;
    if (value == "false" || value == "0" || value == "f") return false;
    return bad_meta_value(key, path, value);
}

Result<std::vector<double>> numbers(const Header& header, const char* key, std::size_t count,
                                    const std::string& path) {
    std::vector<double> found;
    for (const std::string_view word : words(header.get(key))) {
        const auto number = parse_double(word);
        if (!number || !std::isfinite(*number)) return bad_meta_value(key, path, header.get(key));
        found.push_back(*number);
    }
    if (found.size() != count) return bad_meta_value(key, path, header.get(key));
    return found;
}

struct Shape {
    std::size_t axes = 3;
    std::uint64_t channels = 1;
    ClaimedLayout layout;
};

Result<Shape> shape_of(const Header& header, const std::string& path) {
    static const std::map<std::string, VoxelType, std::less<>> types = {
        {"MET_CHAR", VoxelType::i8},        {"MET_UCHAR", VoxelType::u8},  {"MET_SHORT", VoxelType::i16},
        {"MET_USHORT", VoxelType::u16},     {"MET_INT", VoxelType::i32},   {"MET_UINT", VoxelType::u32},
        {"MET_LONG", VoxelType::i32},       {"MET_ULONG", VoxelType::u32}, {"MET_LONG_LONG", VoxelType::i64},
        {"MET_ULONG_LONG", VoxelType::u64}, {"MET_FLOAT", VoxelType::f32}, {"MET_DOUBLE", VoxelType::f64}};
    if (header.has("ObjectType") && header.get("ObjectType") != "Image")
        return key_error("E-MTI-005", "the file does not hold an image", path, header.get("ObjectType"));
    Shape shape;
    const auto axes = parse_integer(header.get("NDims"));
    if (!axes || *axes < 3 || *axes > 10) return bad_meta_value("NDims", path, header.get("NDims"));
    shape.axes = static_cast<std::size_t>(*axes);
    const auto type = types.find(header.get("ElementType"));
    if (type == types.end())
        return key_error("E-MTI-006", "voxels of this type are not supported", path,
                         header.get("ElementType"));
    shape.layout.type = type->second;
    const auto sizes = words(header.get("DimSize"));
    if (sizes.size() != shape.axes) return bad_meta_value("DimSize", path, header.get("DimSize"));
    std::optional<std::uint64_t> volumes = 1;
    for (std::size_t axis = 0; axis < shape.axes; ++axis) {
        const auto size = parse_integer(sizes[axis]);
        if (!size || *size < 1) return bad_meta_value("DimSize", path, header.get("DimSize"));
        if (axis < 3)
            shape.layout.sizes[axis] = static_cast<std::uint64_t>(*size);
        else if (volumes)
            volumes = checked_multiply(*volumes, static_cast<std::uint64_t>(*size));
    }
    if (header.has("ElementNumberOfChannels")) {
        const auto channels = parse_integer(header.get("ElementNumberOfChannels"));
        if (!channels || *channels < 1 || *channels > 65536)
            return bad_meta_value("ElementNumberOfChannels", path, header.get("ElementNumberOfChannels"));
        shape.channels = static_cast<std::uint64_t>(*channels);
        if (volumes) volumes = checked_multiply(*volumes, shape.channels);
    }
    if (!volumes) return bad_meta_value("DimSize", path, header.get("DimSize"));
    shape.layout.volumes = *volumes;
    return shape;
}

Result<double> unit_of(const Header& header, const std::string& path) {
    static const std::map<std::string, double, std::less<>> units = {{"", 1},       {"?", 1},   {"mm", 1},
                                                                     {"um", 0.001}, {"cm", 10}, {"m", 1000}};
    const auto found = units.find(header.get("DistanceUnits"));
    if (found == units.end()) return bad_meta_value("DistanceUnits", path, header.get("DistanceUnits"));
    return found->second;
}

// MetaImage's numbers are LPS by convention (AnatomicalOrientation RAI names where the axes come from),
// whether or not the file says so; only a file that says nothing at all listens to the chosen frame.
Result<ImageGeometry> geometry_of(const Header& header, const Shape& shape, const std::string& path,
                                  const ReadImageOptions& options, RunContext& context) {
    const std::size_t n = shape.axes;
    if (!header.has("ElementSpacing"))
        return key_error("E-MTI-002", "the key ElementSpacing is missing", path, "");
    ANATOMESH_TRY(const std::vector<double> spacing, numbers(header, "ElementSpacing", n, path));
    std::vector<double> offset(n, 0.0), matrix(n * n, 0.0);
    for (std::size_t axis = 0; axis < n; ++axis) matrix[axis * n + axis] = 1;
    if (header.has("Offset")) {
        ANATOMESH_TRY(offset, numbers(header, "Offset", n, path));
    }
    if (header.has("TransformMatrix")) {
        ANATOMESH_TRY(matrix, numbers(header, "TransformMatrix", n * n, path));
    }
    if (!header.has("Offset") || !header.has("TransformMatrix"))
        context.warn(image_warning("W-MTI-002", "the image does not state its position or its directions",
                                   path, "",
                                   "voxel 0 was put at the origin, with axes along those of the patient"));
    const std::string_view orientation = header.get("AnatomicalOrientation");
    if (!orientation.empty() && orientation != "RAI" && orientation.find('?') == std::string_view::npos)
        context.warn(image_warning("W-MTI-003",
                                   "AnatomicalOrientation is not RAI, which the transform requires", path,
                                   shown(orientation), "it was ignored, and the transform was read as LPS"));
    ANATOMESH_TRY(const double millimetres, unit_of(header, path));
    ImageGeometry geometry;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!(spacing[axis] > 0)) return bad_meta_value("ElementSpacing", path, header.get("ElementSpacing"));
        geometry.size[axis] = static_cast<std::uint32_t>(shape.layout.sizes[axis]);
        const double* direction = matrix.data() + axis * n;  // the direction of an axis is a row
        geometry.step[axis] = millimetres * spacing[axis] * Vec3{direction[0], direction[1], direction[2]};
    }
    geometry.origin = millimetres * Vec3{offset[0], offset[1], offset[2]};
    const bool silent = orientation.empty() && !header.has("TransformMatrix");
    if (silent && options.frame == ImageFrame::ras) turn_ras_lps(geometry);
    ANATOMESH_CHECK_STATUS(check_geometry(geometry, path));
    return geometry;
}

// The bytes that hold the image: what follows the header, or a data file; HeaderSize of them are skipped.
Result<std::span<const std::byte>> after_header(std::span<const std::byte> bytes, const Header& header,
                                                std::uint64_t claimed, bool compressed,
                                                const std::string& path) {
    if (!header.has("HeaderSize")) return bytes;
    const auto skip = parse_integer(header.get("HeaderSize"));
    const bool from_end = skip && *skip == -1 && !compressed;
    if (!skip || (*skip < 0 && !from_end) || (*skip > 0 && static_cast<std::uint64_t>(*skip) > bytes.size()))
        return bad_meta_value("HeaderSize", path, header.get("HeaderSize"));
    if (from_end) return bytes.size() > claimed ? bytes.last(claimed) : bytes;
    return bytes.subspan(static_cast<std::size_t>(*skip));
}

Status take_meta_data(std::span<const std::byte> bytes, const Header& header, const Shape& shape,
                      std::uint64_t claimed, const std::string& path, const ReadImageOptions& options,
                      RunContext& context, RawImage& raw) {
    ANATOMESH_TRY(const bool compressed, boolean(header, "CompressedData", false, path));
    ANATOMESH_TRY(const bool binary, boolean(header, "BinaryData", true, path));
    ANATOMESH_TRY(const bool big_endian, boolean(header, "ElementByteOrderMSB", false, path));
    ANATOMESH_TRY(bytes, after_header(bytes, header, claimed, compressed, path));
    raw.type = shape.layout.type;
    raw.order = big_endian ? std::endian::big : std::endian::little;
    if (compressed) {
        ANATOMESH_TRY(raw.storage, inflate(bytes, path, options.limits, context, claimed));
        bytes = raw.storage.bytes();
    }
    if (!binary) {
        ANATOMESH_TRY(ByteBuffer values,
                      parse_text_values(as_text(bytes), claimed / byte_size(shape.layout.type), path));
        raw.storage = std::move(values);
        raw.data = raw.storage.bytes();
        raw.type = VoxelType::f64;
        raw.order = std::endian::native;
        return Nothing{};
    }
    ANATOMESH_CHECK_STATUS(check_length(claimed, bytes.size(), path, context));
    raw.data = bytes;
    return Nothing{};
}

}  // namespace

Result<RawImage> read_metaimage(const InputFile& file, std::span<const std::byte> content,
                                const ReadImageOptions& options, RunContext& context) {
    const std::string& path = file.path;
    ANATOMESH_TRY(const Header header, parse_header(content, path, context));
    ANATOMESH_TRY(const Shape shape, shape_of(header, path));
    ANATOMESH_TRY(const std::uint64_t claimed, claimed_bytes(shape.layout, path, options));
    RawImage raw;
    if (has_tracked_frames(header.sequence)) {
        ANATOMESH_TRY(raw.poses, read_poses(header.sequence, shape.layout.sizes, path, options, context));
        raw.geometry.size = {static_cast<std::uint32_t>(shape.layout.sizes[0]),
                             static_cast<std::uint32_t>(shape.layout.sizes[1]),
                             static_cast<std::uint32_t>(shape.layout.sizes[2])};
    } else {
        ANATOMESH_TRY(raw.geometry, geometry_of(header, shape, path, options, context));
    }
    ANATOMESH_TRY(const std::uint64_t volume,
                  chosen_volume(shape.layout.volumes, path, options, shape.channels));

    const std::string_view data_name = header.get("ElementDataFile");
    if (lower_case(data_name) == "local") {
        ANATOMESH_CHECK_STATUS(take_meta_data(content.subspan(header.data_begin), header, shape, claimed,
                                              path, options, context, raw));
    } else {
        ANATOMESH_TRY(const std::string data_path, data_file_path(path, data_name));
        ANATOMESH_TRY(InputFile data_file, read_input_file(data_path, options.limits));
        raw.further_inputs.push_back({data_path, data_file.sha256()});
        ANATOMESH_CHECK_STATUS(
            take_meta_data(data_file.bytes(), header, shape, claimed, data_path, options, context, raw));
        if (raw.storage.size() == 0) raw.storage = std::move(data_file.content);
    }
    // Channels are interleaved with the voxels, further axes follow one another.
    const std::uint64_t channel = volume % shape.channels, rest = volume / shape.channels;
    const std::uint64_t first = rest * raw.geometry.voxel_count() * shape.channels + channel;
    raw.data = raw.data.subspan(first * byte_size(raw.type));
    raw.stride = shape.channels;
    return raw;
}

}  // namespace anatomesh
