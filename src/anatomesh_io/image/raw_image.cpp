#include "anatomesh_io/image/raw_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <system_error>

#include "anatomesh/geom/numbers.h"
#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

std::size_t byte_size(VoxelType type) {
    switch (type) {
        case VoxelType::u8:
        case VoxelType::i8:
            return 1;
        case VoxelType::u16:
        case VoxelType::i16:
            return 2;
        case VoxelType::u32:
        case VoxelType::i32:
        case VoxelType::f32:
            return 4;
        case VoxelType::u64:
        case VoxelType::i64:
        case VoxelType::f64:
            return 8;
    }
    return 1;
}

const char* name_of(VoxelType type) {
    constexpr std::array<const char*, 10> names = {"uint8", "int8",   "uint16", "int16",   "uint32",
                                                   "int32", "uint64", "int64",  "float32", "float64"};
    return names[static_cast<std::size_t>(type)];
}

bool is_integer(VoxelType type) {
    return type != VoxelType::f32 && type != VoxelType::f64;
}

Error image_error(const char* code, std::string message, const std::string& path, std::string value,
                  std::string next_step) {
    return {ErrorKind::input, code, std::move(message), Place{path, "", "", "", std::move(value)},
            std::move(next_step)};
}

Warning image_warning(const char* code, std::string message, const std::string& path, std::string value,
                      std::string what_was_done) {
    return {code, std::move(message), Place{path, "", "", "", std::move(value)}, std::move(what_was_done)};
}

Result<std::uint64_t> claimed_bytes(const ClaimedLayout& layout, const std::string& path,
                                    const ReadImageOptions& options) {
    std::optional<std::uint64_t> voxels = layout.volumes;
    for (const std::uint64_t size : layout.sizes) {
        if (size == 0 || size > std::numeric_limits<std::uint32_t>::max())
            return image_error(
                "E-IMG-003", "an axis of the image has an impossible number of voxels", path,
                fmt::format("{} x {} x {}", layout.sizes[0], layout.sizes[1], layout.sizes[2]));
        if (voxels) voxels = checked_multiply(*voxels, size);
    }
    if (!voxels || *voxels > options.max_voxels) {
        Error error = image_error("E-IMG-004",
                                  fmt::format("the image has more than {} voxels", options.max_voxels), path,
                                  fmt::format("{} x {} x {}, {} volumes", layout.sizes[0], layout.sizes[1],
                                              layout.sizes[2], layout.volumes),
                                  "crop or resample the image");
        error.kind = ErrorKind::limit;
        return error;
    }
    // Cannot overflow: max_voxels may be anything, so it is checked all the same.
    const auto bytes = checked_multiply(*voxels, byte_size(layout.type));
    if (!bytes) return image_error("E-IMG-003", "the size of the image does not fit 64 bits", path);
    return *bytes;
}

Status check_length(std::uint64_t claimed, std::uint64_t available, const std::string& path,
                    RunContext& context) {
    if (available < claimed)
        return image_error("E-IMG-005",
                           fmt::format("the header announces {} bytes of image data, but the file holds {}",
                                       claimed, available),
                           path, "", "copy or export the image again");
    if (available > claimed)
        context.warn(image_warning(
            "W-IMG-001", fmt::format("the file has {} bytes after its image data", available - claimed), path,
            "", "they were ignored"));
    return Nothing{};
}

Result<std::uint64_t> chosen_volume(std::uint64_t volumes, const std::string& path,
                                    const ReadImageOptions& options, std::uint64_t channels) {
    if (volumes == 1 && !options.volume) return std::uint64_t{0};
    if (!options.volume && channels > 1)
        return image_error(
            "E-IMG-008",
            fmt::format(
                "each pixel of the image has {} channels, as in colour images; the program reads one grey "
                "value",
                channels),
            path, "",
            fmt::format(
                "convert the image to grey, or choose a channel with --volume N (0 is the first: red){}",
                volumes > channels ? fmt::format("; N up to {} counts the channels of all {} volumes",
                                                 volumes - 1, volumes / channels)
                                   : ""));
    if (!options.volume)
        return image_error("E-IMG-008", fmt::format("the image holds {} volumes", volumes), path, "",
                           fmt::format("choose one with --volume N, 0 to {}", volumes - 1));
    if (*options.volume >= volumes)
        return image_error("E-IMG-009",
                           fmt::format("the image has no volume of this number; it holds {}", volumes), path,
                           fmt::format("{}", *options.volume),
                           fmt::format("choose one with --volume N, 0 to {}", volumes - 1));
    return *options.volume;
}

Status check_geometry(const ImageGeometry& geometry, const std::string& path) {
    // Smaller voxels are refused as damaged: none is measured at a nanometre. [mm; > 0; C]
    constexpr double shortest_mm = 1e-6;
    double volume_scale = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double step = length(geometry.step[axis]);
        // The negated comparison also catches NaN.
        if (!(step >= shortest_mm && step <= coordinate_bound_mm))
            return image_error(std::isfinite(step) ? "E-IMG-007" : "E-IMG-006",
                               fmt::format("the voxel spacing along axis {} is not possible", "ijk"[axis]),
                               path, fmt::format("{} mm", step), "correct the header of the image");
        volume_scale *= step;
    }
    // Voxels that are longer, in their widths, come of a damaged header: a model of them would have a thousand cells for
    // each. [1; > 1; D slices of 10 mm of pixels of 0.05 mm]
    constexpr double longest_in_widths = 200;
    double shortest = std::numeric_limits<double>::infinity(), longest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (geometry.size[axis] < 2) continue;
        shortest = std::min(shortest, length(geometry.step[axis]));
        longest = std::max(longest, length(geometry.step[axis]));
    }
    if (longest > longest_in_widths * shortest)
        return image_error(
            "E-IMG-018",
            fmt::format(
                "the voxels are {:.0f} times as long as they are wide, which is most likely a mistake",
                longest / shortest),
            path, fmt::format("{:.4g} and {:.4g} mm", longest, shortest),
            "correct the spacings in the header of the image");
    const double volume = dot(geometry.step[0], cross(geometry.step[1], geometry.step[2]));
    if (!(std::abs(volume) > 1e-6 * volume_scale))
        return image_error("E-IMG-007", "the axes of the image lie in one plane (singular transform)", path,
                           fmt::format("determinant {}", volume), "correct the header of the image");
    for (int corner = 0; corner < 8; ++corner) {
        const auto end = [&](int axis) { return corner >> axis & 1 ? geometry.size[axis] - 1.0 : 0.0; };
        const Vec3 p = geometry.position(end(0), end(1), end(2));
        for (const double coordinate : {p.x, p.y, p.z})
            if (!(std::abs(coordinate) <= coordinate_bound_mm))
                return image_error("E-IMG-006", "the position of the image is beyond 1e7 mm or not a number",
                                   path, fmt::format("{}", coordinate), "correct the header of the image");
    }
    return Nothing{};
}

void turn_ras_lps(ImageGeometry& geometry) {
    // 0 - x rather than -x: no negative zeros.
    const auto turned = [](Vec3 v) { return Vec3{0 - v.x, 0 - v.y, v.z}; };
    geometry.origin = turned(geometry.origin);
    for (Vec3& step : geometry.step) step = turned(step);
}

Result<std::array<Vec3, 3>> orientation_steps(const std::string& letters, const std::string& path) {
    std::array<Vec3, 3> steps;
    int axes_seen = 0;
    for (std::size_t i = 0; i < letters.size() && i < 3; ++i) switch (letters[i]) {
            case 'L':
                steps[i] = {1, 0, 0};
                axes_seen |= 1;
                break;
            case 'R':
                steps[i] = {-1, 0, 0};
                axes_seen |= 1;
                break;
            case 'P':
                steps[i] = {0, 1, 0};
                axes_seen |= 2;
                break;
            case 'A':
                steps[i] = {0, -1, 0};
                axes_seen |= 2;
                break;
            case 'S':
                steps[i] = {0, 0, 1};
                axes_seen |= 4;
                break;
            case 'I':
                steps[i] = {0, 0, -1};
                axes_seen |= 4;
                break;
            default:
                break;
        }
    if (letters.size() != 3 || axes_seen != 7) {
        Error error =
            image_error("E-IMG-011", "--assume-orientation needs one letter of each pair L R, A P and S I",
                        path, shown(letters), "give for example --assume-orientation RAS");
        error.kind = ErrorKind::usage;
        return error;
    }
    return steps;
}

// ---- text

std::optional<double> parse_double(std::string_view text) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    std::int64_t value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

constexpr std::string_view blanks = " \t\r\n\v\f";

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> found;
    while (!(text = trimmed(text)).empty()) {
        const std::size_t end = std::min(text.find_first_of(blanks), text.size());
        found.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return found;
}

std::string shown(std::string_view text) {
    std::string safe(text.substr(0, 40));
    for (char& c : safe)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
    if (text.size() > 40) safe += "...";
    return safe;
}

Result<ByteBuffer> parse_text_values(std::string_view text, std::uint64_t count, const std::string& path) {
    // Each value takes a digit and, but for the last, a blank.
    if (count > text.size() / 2 + 1)
        return image_error("E-IMG-005",
                           fmt::format("the header announces {} values, but only {} bytes of text follow",
                                       count, text.size()),
                           path, "", "copy or export the image again");
    ByteBuffer values;
    if (!values.reserve(count * sizeof(double)))
        return Error{ErrorKind::limit, "E-INP-009", "the memory does not suffice for the image",
                     Place{path, "", "", "", ""}, "use a machine with more memory, or a smaller image"};
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::size_t begin = std::min(text.find_first_not_of(blanks), text.size());
        text.remove_prefix(begin);
        const std::string_view word = text.substr(0, std::min(text.find_first_of(blanks), text.size()));
        text.remove_prefix(word.size());
        const auto value = parse_double(word);
        if (word.empty())
            return image_error("E-IMG-005",
                               fmt::format("the header announces {} values, but the file holds {}", count, i),
                               path, "", "copy or export the image again");
        if (!value)
            return image_error("E-IMG-014", fmt::format("value {} of the image is no number", i), path,
                               shown(word), "correct the file");
        std::memcpy(values.data() + i * sizeof(double), &*value, sizeof(double));
    }
    values.set_size(count * sizeof(double));
    return values;
}

Result<std::string> data_file_path(const std::string& path, std::string_view name) {
    namespace fs = std::filesystem;
    if (lower_case(name.substr(0, 4)) == "list" || name.find('%') != std::string_view::npos)
        return image_error("E-IMG-015",
                           "the image is stored in several data files, which the program does not read", path,
                           shown(name), "save it as one file");
    const fs::path relative{std::string(name)};
    bool climbs = false;
    for (const fs::path& part : relative)
        if (part == "..") climbs = true;
    if (name.empty() || name.find('\0') != std::string_view::npos || relative.is_absolute() || climbs ||
        name.find("://") != std::string_view::npos)
        return image_error("E-IMG-013", "the data file must lie in the folder of the header", path,
                           shown(name), "move the data file beside the header and name it there");
    const fs::path target = fs::path(path).parent_path() / relative;
    // A link must not lead out either.
    std::error_code ignored;
    const fs::path folder = fs::weakly_canonical(fs::absolute(path).parent_path(), ignored);
    const fs::path real = fs::weakly_canonical(fs::absolute(target), ignored);
    const auto [end_of_folder, rest] = std::mismatch(folder.begin(), folder.end(), real.begin(), real.end());
    if (end_of_folder != folder.end())
        return image_error("E-IMG-013", "the data file must lie in the folder of the header", path,
                           shown(name), "move the data file beside the header and name it there");
    if (fs::equivalent(target, path, ignored))
        return image_error("E-IMG-013", "the header names itself as its data file", path, shown(name),
                           "correct the header");
    return target.string();
}

}  // namespace anatomesh
