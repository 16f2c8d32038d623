#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/property_list.h"
#include "anatomesh_io/image/raw_image.h"
#include "anatomesh_io/image/tar_archive.h"

namespace anatomesh {

namespace {

// The one entry of that name in whatever folder. E-INV-005 when there is none, or more than one.
Result<TarEntry> find_entry(const std::vector<TarEntry>& entries, std::string_view name,
                            const std::string& path) {
    const TarEntry* found = nullptr;
    for (const TarEntry& entry : entries) {
        const std::string_view base = entry.name.substr(entry.name.find_last_of('/') + 1);
        if (base != name) continue;
        if (found)
            return image_error("E-INV-005", fmt::format("the archive holds {} twice", shown(name)), path, "",
                               "save the project again");
        found = &entry;
    }
    if (!found)
        return image_error("E-INV-005",
                           fmt::format("the archive holds no {}: it is no InVesalius project", shown(name)),
                           path, "", "give an .inv3 file, an image or contours");
    return *found;
}

std::string joined(const std::vector<std::string_view>& values) {
    std::string text;
    for (const std::string_view value : values) text += (text.empty() ? "" : ", ") + shown(value);
    return text;
}

Result<std::array<double, 3>> three_numbers(const PropertyList& list, const char* key,
                                            const std::string& path) {
    const auto values = values_at(list, key);
    std::array<double, 3> numbers{};
    bool good = values.size() == 3;
    for (std::size_t i = 0; good && i < 3; ++i) {
        const auto number = parse_double(values[i]);
        good = number && *number > 0 && *number < 1e9;
        if (good) numbers[i] = *number;
    }
    if (!good)
        return image_error("E-INV-006", fmt::format("{} is not three positive numbers", key), path,
                           joined(values), "save the project again");
    return numbers;
}

Result<VoxelType> voxel_type(const PropertyList& list, const std::string& path) {
    constexpr std::array types = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16, VoxelType::i16,
                                  VoxelType::u32, VoxelType::i32, VoxelType::u64, VoxelType::i64,
                                  VoxelType::f32, VoxelType::f64};
    const auto values = values_at(list, "matrix/dtype");
    for (const VoxelType type : types)
        if (values.size() == 1 && values[0] == name_of(type)) return type;
    return image_error("E-INV-007", "the voxel type of the matrix is not supported", path, joined(values),
                       "save the project again");
}

}  // namespace

Result<RawImage> read_invesalius(const InputFile& file, std::span<const std::byte> content,
                                 const ReadImageOptions& options, RunContext& context) {
    const std::string& path = file.path;
    ANATOMESH_TRY(const std::vector<TarEntry> entries, tar_entries(content, path));
    ANATOMESH_TRY(const TarEntry main, find_entry(entries, "main.plist", path));
    ANATOMESH_TRY(const PropertyList list, parse_property_list(as_text(main.content), path));
    ANATOMESH_TRY(const auto shape, three_numbers(list, "matrix/shape", path));
    ANATOMESH_TRY(const auto spacing, three_numbers(list, "spacing", path));
    const auto names = values_at(list, "matrix/filename");
    const std::string_view name = names.empty() ? "matrix.dat" : names.front();
    ANATOMESH_TRY(const TarEntry matrix, find_entry(entries, name, path));

    RawImage raw;
    ANATOMESH_TRY(raw.type, voxel_type(list, path));
    ClaimedLayout layout;
    layout.type = raw.type;
    for (int axis = 0; axis < 3; ++axis) {
        const double size = shape[2 - axis];  // the matrix is indexed z, y, x
        layout.sizes[axis] = static_cast<std::uint64_t>(size);
        if (static_cast<double>(layout.sizes[axis]) != size)
            return image_error("E-INV-006", "matrix/shape is not three positive integers", path,
                               fmt::format("{}", size), "save the project again");
    }
    ANATOMESH_TRY(const std::uint64_t claimed, claimed_bytes(layout, path, options));
    ANATOMESH_CHECK_STATUS(check_length(claimed, matrix.content.size(), path, context));
    ANATOMESH_CHECK_STATUS(chosen_volume(1, path, options));
    raw.data = matrix.content;
    for (int axis = 0; axis < 3; ++axis)
        raw.geometry.size[axis] = static_cast<std::uint32_t>(layout.sizes[axis]);
    // InVesalius keeps no position; its rows run to anterior, read otherwise they mirror the patient.
    raw.geometry.step = {Vec3{spacing[0], 0, 0}, Vec3{0, -spacing[1], 0}, Vec3{0, 0, spacing[2]}};
    ANATOMESH_CHECK_STATUS(check_geometry(raw.geometry, path));
    return raw;
}

}  // namespace anatomesh
