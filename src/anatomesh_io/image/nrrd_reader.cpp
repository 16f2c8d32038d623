#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/nrrd_header.h"
#include "anatomesh_io/image/raw_image.h"
#include "anatomesh_io/image/tracked_frames.h"

namespace anatomesh {

namespace {

// Which axes of the file are the three of space; the others count volumes.
struct Axes {
    std::size_t first_spatial = 0;
    ClaimedLayout layout;
    std::uint64_t volumes_before = 1;  // product of the axes that run faster than the spatial ones
};

// Of a tracked sequence: columns, rows, frames, the last of which is no axis in space.
Result<Axes> frame_axes(const NrrdHeader& header, const std::string& path) {
    if (header.sizes.size() != 3)
        return image_error("E-NRD-008", "a tracked sequence has three axes: columns, rows, frames", path,
                           fmt::format("{}", header.sizes.size()), "save the sequence with grey frames");
    Axes axes;
    axes.layout.type = header.type;
    for (std::size_t axis = 0; axis < 3; ++axis) axes.layout.sizes[axis] = header.sizes[axis];
    return axes;
}

Result<Axes> spatial_axes(const NrrdHeader& header, const std::string& path) {
    std::vector<std::size_t> spatial;
    for (std::size_t axis = 0; axis < header.sizes.size(); ++axis) {
        bool in_space = axis < 3;
        if (!header.directions.empty())
            in_space = header.directions[axis].has_value();
        else if (!header.spacings.empty())
            in_space = !std::isnan(header.spacings[axis]);
        if (in_space) spatial.push_back(axis);
    }
    if (spatial.size() != 3 || spatial[2] != spatial[0] + 2)
        return image_error("E-NRD-008", "the image has not exactly three neighbouring axes in space", path,
                           fmt::format("{}", spatial.size()), "save it as a volume");
    Axes axes;
    axes.first_spatial = spatial[0];
    axes.layout.type = header.type;
    for (std::size_t axis = 0; axis < header.sizes.size(); ++axis) {
        if (axis >= spatial[0] && axis <= spatial[2]) {
            axes.layout.sizes[axis - spatial[0]] = header.sizes[axis];
            continue;
        }
        const auto volumes = checked_multiply(axes.layout.volumes, header.sizes[axis]);
        if (!volumes)
            return image_error("E-NRD-005", "the number of volumes does not fit 64 bits", path, "",
                               "correct the header of the image");
        axes.layout.volumes = *volumes;
        if (axis < spatial[0]) axes.volumes_before = *volumes;
    }
    return axes;
}

// Signs that turn the space's numbers to LPS. E-NRD-009 when the space says nothing about the patient and no
// frame was chosen.
Result<Vec3> signs_to_lps(const NrrdHeader& header, const std::string& path, const ReadImageOptions& options,
                          RunContext& context) {
    static const std::map<std::string, Vec3, std::less<>> spaces = {
        {"left-posterior-superior", {1, 1, 1}},        {"lps", {1, 1, 1}},
        {"right-anterior-superior", {-1, -1, 1}},      {"ras", {-1, -1, 1}},
        {"left-anterior-superior", {1, -1, 1}},        {"las", {1, -1, 1}},
        {"left-posterior-superior-time", {1, 1, 1}},   {"lpst", {1, 1, 1}},
        {"right-anterior-superior-time", {-1, -1, 1}}, {"rast", {-1, -1, 1}},
        {"left-anterior-superior-time", {1, -1, 1}},   {"last", {1, -1, 1}}};
    if (const auto known = spaces.find(header.space); known != spaces.end()) return known->second;
    if (!options.frame)
        return image_error("E-NRD-009",
                           header.space.empty() ? "the image does not state its axes (the field 'space')"
                                                : "the field 'space' does not state the axes of the patient",
                           path, shown(header.space), "give --frame LPS or --frame RAS");
    const bool lps = *options.frame == ImageFrame::lps;
    context.warn(image_warning("W-NRD-003", "the image does not state the axes of the patient", path,
                               shown(header.space), lps ? "--frame LPS was used" : "--frame RAS was used"));
    return lps ? Vec3{1, 1, 1} : Vec3{-1, -1, 1};
}

Result<ImageGeometry> geometry_of(const NrrdHeader& header, const Axes& axes, const std::string& path,
                                  const ReadImageOptions& options, RunContext& context) {
    ANATOMESH_TRY(const Vec3 signs, signs_to_lps(header, path, options, context));
    const auto turned = [&](Vec3 v) {
        return header.millimetres * Vec3{signs.x * v.x, signs.y * v.y, signs.z * v.z};
    };
    constexpr std::array<Vec3, 3> units = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    ImageGeometry geometry;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t axis = axes.first_spatial + i;
        geometry.size[i] = static_cast<std::uint32_t>(axes.layout.sizes[i]);
        if (!header.directions.empty())
            geometry.step[i] = turned(*header.directions[axis]);
        else if (!header.spacings.empty())
            geometry.step[i] = turned(header.spacings[axis] * units[i]);
        else
            return image_error("E-NRD-004", "the voxel spacing is missing ('space directions' or 'spacings')",
                               path, "", "correct the header of the image");
    }
    if (header.origin)
        geometry.origin = turned(*header.origin);
    else
        context.warn(image_warning("W-NRD-004", "the field 'space origin' is missing", path, "",
                                   "voxel 0 was put at the origin"));
    ANATOMESH_CHECK_STATUS(check_geometry(geometry, path));
    return geometry;
}

// Skips lines, then (in raw and text data) bytes. E-NRD-010 when that passes the end.
Result<std::span<const std::byte>> after_skips(std::span<const std::byte> bytes, const NrrdHeader& header,
                                               const std::string& path) {
    ByteReader reader(bytes);
    for (std::uint64_t line = 0; line < header.line_skip; ++line)
        if (!reader.read_line())
            return image_error("E-NRD-010", "'line skip' passes the end of the file", path,
                               fmt::format("{}", header.line_skip), "correct the header of the image");
    const bool skip_bytes = header.encoding != NrrdEncoding::gzip && header.byte_skip > 0;
    if (skip_bytes && !reader.skip(static_cast<std::uint64_t>(header.byte_skip)))
        return image_error("E-NRD-010", "'byte skip' passes the end of the file", path,
                           fmt::format("{}", header.byte_skip), "correct the header of the image");
    return bytes.subspan(reader.position());
}

// Sets raw.data to all volumes of the image. `bytes` is what follows the header, or the data file; it
// outlives raw.
Status take_data(std::span<const std::byte> bytes, const NrrdHeader& header, const ClaimedLayout& layout,
                 std::uint64_t claimed, const std::string& path, const ReadImageOptions& options,
                 RunContext& context, RawImage& raw) {
    ANATOMESH_TRY(bytes, after_skips(bytes, header, path));
    if (header.encoding == NrrdEncoding::text) {
        const std::uint64_t values = claimed / byte_size(layout.type);
        ANATOMESH_TRY(raw.storage, parse_text_values(as_text(bytes), values, path));
        raw.data = raw.storage.bytes();
        raw.type = VoxelType::f64;
        raw.order = std::endian::native;
        return Nothing{};
    }
    if (header.encoding == NrrdEncoding::gzip) {
        ANATOMESH_TRY(raw.storage, inflate(bytes, path, options.limits, context, claimed));
        bytes = raw.storage.bytes();
        if (static_cast<std::uint64_t>(header.byte_skip) > bytes.size())
            return image_error("E-NRD-010", "'byte skip' passes the end of the data", path,
                               fmt::format("{}", header.byte_skip), "correct the header of the image");
        bytes = bytes.subspan(static_cast<std::size_t>(header.byte_skip));
    }
    // -1: the data ends where the file ends.
    if (header.byte_skip == -1 && bytes.size() > claimed) bytes = bytes.last(claimed);
    ANATOMESH_CHECK_STATUS(check_length(claimed, bytes.size(), path, context));
    raw.data = bytes;
    return Nothing{};
}

// 3D Slicer writes Segment3_Name:=..., Segment3_LabelValue:=..., Segment3_Color:=r g b (0 to 1), and, where
// segments overlap, Segment3_Layer:=... for the volume that the segment is in: a label may mean another one
// in each.
std::vector<Structure> segments_of(const NrrdHeader& header, std::uint64_t volume) {
    struct Segment {
        Structure structure;
        bool has_label = false;
        std::int64_t layer = 0;
    };
    std::map<std::int64_t, Segment> segments;
    for (const auto& [key, value] : header.pairs) {
        const std::size_t bar = key.find('_');
        if (!key.starts_with("Segment") || bar == std::string::npos) continue;
        const auto number = parse_integer(std::string_view(key).substr(7, bar - 7));
        const std::string_view field = std::string_view(key).substr(bar + 1);
        if (!number || *number < 0 || segments.size() > 65535) continue;
        if (field == "Name") segments[*number].structure.name = value;
        if (field == "LabelValue") {
            const auto label = parse_integer(value);
            if (!label || *label < 1 || *label > 16777215) continue;
            segments[*number].structure.number = static_cast<std::int32_t>(*label);
            segments[*number].has_label = true;
        }
        if (field == "Layer") segments[*number].layer = parse_integer(value).value_or(0);
        if (field == "Color") {
            const auto parts = words(value);
            for (std::size_t i = 0; i < 3 && parts.size() == 3; ++i)
                if (const auto share = parse_double(parts[i]); share && *share >= 0 && *share <= 1)
                    segments[*number].structure.color[i] =
                        static_cast<std::uint8_t>(std::lround(255 * *share));
        }
    }
    std::vector<Structure> structures;
    for (const auto& [number, segment] : segments)
        if (segment.has_label && segment.layer == static_cast<std::int64_t>(volume))
            structures.push_back(segment.structure);
    std::stable_sort(structures.begin(), structures.end(),
                     [](const Structure& a, const Structure& b) { return a.number < b.number; });
    return structures;
}

}  // namespace

Result<RawImage> read_nrrd(const InputFile& file, std::span<const std::byte> content,
                           const ReadImageOptions& options, RunContext& context) {
    const std::string& path = file.path;
    ANATOMESH_TRY(const NrrdHeader header, parse_nrrd_header(content, path, context));
    const bool is_tracked = has_tracked_frames(header.pairs);
    ANATOMESH_TRY(const Axes axes, is_tracked ? frame_axes(header, path) : spatial_axes(header, path));
    ANATOMESH_TRY(const std::uint64_t claimed, claimed_bytes(axes.layout, path, options));
    RawImage raw;
    raw.type = header.type;
    raw.order = header.order.value_or(std::endian::little);
    if (is_tracked) {
        ANATOMESH_TRY(raw.poses, read_poses(header.pairs, axes.layout.sizes, path, options, context));
        for (std::size_t axis = 0; axis < 3; ++axis)
            raw.geometry.size[axis] = static_cast<std::uint32_t>(axes.layout.sizes[axis]);
    } else {
        ANATOMESH_TRY(raw.geometry, geometry_of(header, axes, path, options, context));
    }
    ANATOMESH_TRY(const std::uint64_t volume, chosen_volume(axes.layout.volumes, path, options));
    raw.structures = segments_of(header, volume);

    if (header.data_file.empty()) {
        ANATOMESH_CHECK_STATUS(take_data(content.subspan(header.data_begin), header, axes.layout, claimed,
                                         path, options, context, raw));
    } else {
        ANATOMESH_TRY(const std::string data_path, data_file_path(path, header.data_file));
        ANATOMESH_TRY(InputFile data_file, read_input_file(data_path, options.limits));
        raw.further_inputs.push_back({data_path, data_file.sha256()});
        ANATOMESH_CHECK_STATUS(
            take_data(data_file.bytes(), header, axes.layout, claimed, data_path, options, context, raw));
        if (raw.storage.size() == 0) raw.storage = std::move(data_file.content);
    }
    // Volumes interleaved with the voxels are stepped over, those one after another are cut out.
    const std::size_t value_bytes = byte_size(raw.type);
    const std::uint64_t before = volume % axes.volumes_before, after = volume / axes.volumes_before;
    const std::uint64_t first = after * raw.geometry.voxel_count() * axes.volumes_before + before;
    raw.data = raw.data.subspan(first * value_bytes);
    raw.stride = axes.volumes_before;
    return raw;
}

}  // namespace anatomesh
