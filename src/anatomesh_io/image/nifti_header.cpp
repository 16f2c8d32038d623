#include "anatomesh_io/image/nifti_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

namespace {

// The fields of both versions, as the file has them, in the widest types.
struct NiftiFields {
    std::string_view magic;
    std::int32_t datatype = 0, bitpix = 0;
    std::array<std::int64_t, 8> dim{};
    std::array<double, 8> pixdim{};
    double vox_offset = 0;
    double slope = 0, intercept = 0;
    std::int32_t units = 0, qform_code = 0, sform_code = 0;
    std::array<double, 3> quaternion{};
    std::array<double, 3> qoffset{};
    std::array<std::array<double, 4>, 3> srow{};
};

template <class T, class Target>
void take(ByteReader& reader, Target& target) {
    target = static_cast<Target>(reader.read<T>().value_or(T{}));
}

template <class T, class Target, std::size_t n>
void take(ByteReader& reader, std::array<Target, n>& targets) {
    for (Target& target : targets) take<T>(reader, target);
}

// Requires: 348 bytes. Offsets of nifti1.h.
NiftiFields fields_of_version_1(ByteReader reader) {
    NiftiFields f;
    reader.seek(40);
    take<std::int16_t>(reader, f.dim);
    reader.seek(70);
    take<std::int16_t>(reader, f.datatype);
    take<std::int16_t>(reader, f.bitpix);
    reader.seek(76);
    take<float>(reader, f.pixdim);
    take<float>(reader, f.vox_offset);
    take<float>(reader, f.slope);
    take<float>(reader, f.intercept);
    reader.seek(123);
    take<std::uint8_t>(reader, f.units);
    reader.seek(252);
    take<std::int16_t>(reader, f.qform_code);
    take<std::int16_t>(reader, f.sform_code);
    take<float>(reader, f.quaternion);
    take<float>(reader, f.qoffset);
    for (auto& row : f.srow) take<float>(reader, row);
    reader.seek(344);
    f.magic = reader.read_text(4).value_or("");
    return f;
}

// Requires: 540 bytes. Offsets of nifti2.h.
NiftiFields fields_of_version_2(ByteReader reader) {
    NiftiFields f;
    reader.seek(4);
    f.magic = reader.read_text(8).value_or("");
    take<std::int16_t>(reader, f.datatype);
    take<std::int16_t>(reader, f.bitpix);
    take<std::int64_t>(reader, f.dim);
    reader.seek(104);
    take<double>(reader, f.pixdim);
    std::int64_t offset = 0;
    take<std::int64_t>(reader, offset);
    // Beyond 2^53 the double is not exact, and far beyond any file.
    f.vox_offset = static_cast<double>(offset);
    take<double>(reader, f.slope);
    take<double>(reader, f.intercept);
    reader.seek(344);
    take<std::int32_t>(reader, f.qform_code);
    take<std::int32_t>(reader, f.sform_code);
    take<double>(reader, f.quaternion);
    take<double>(reader, f.qoffset);
    for (auto& row : f.srow) take<double>(reader, row);
    reader.seek(500);
    take<std::int32_t>(reader, f.units);
    return f;
}

struct DataType {
    int code;
    const char* name;
    std::optional<VoxelType> type;
    int bits;
};

constexpr std::array<DataType, 18> data_types = {{
    {1, "binary", std::nullopt, 1},
    {2, "uint8", VoxelType::u8, 8},
    {4, "int16", VoxelType::i16, 16},
    {8, "int32", VoxelType::i32, 32},
    {16, "float32", VoxelType::f32, 32},
    {32, "complex64", std::nullopt, 64},
    {64, "float64", VoxelType::f64, 64},
    {128, "RGB24", std::nullopt, 24},
    {256, "int8", VoxelType::i8, 8},
    {512, "uint16", VoxelType::u16, 16},
    {768, "uint32", VoxelType::u32, 32},
    {1024, "int64", VoxelType::i64, 64},
    {1280, "uint64", VoxelType::u64, 64},
    {1536, "float128", std::nullopt, 128},
    {1792, "complex128", std::nullopt, 128},
    {2048, "complex256", std::nullopt, 256},
    {2304, "RGBA32", std::nullopt, 32},
    {0, "unknown", std::nullopt, 0},
}};

// Version and byte order by the header size; nothing when it is neither 348 nor 540 in any order.
std::optional<std::pair<int, std::endian>> version_of(ByteReader reader) {
    const std::uint32_t size = reader.read<std::uint32_t>().value_or(0);
    for (const auto& [bytes, version] : {std::pair{348U, 1}, std::pair{540U, 2}}) {
        if (size == bytes) return std::pair{version, std::endian::little};
        if (size == byte_swapped(bytes)) return std::pair{version, std::endian::big};
    }
    return std::nullopt;
}

Status check_magic(const NiftiFields& fields, NiftiHeader& header, const std::string& path) {
    using namespace std::string_view_literals;
    const bool one = header.version == 1;
    const std::string_view single = one ? "n+1\0"sv : "n+2\0\r\n\032\n"sv;
    const std::string_view pair = one ? "ni1\0"sv : "ni2\0\r\n\032\n"sv;
    if (fields.magic != single && fields.magic != pair) {
        const bool analyze = one && fields.magic == "\0\0\0\0"sv;
        return image_error("E-NII-003",
                           analyze
                               ? "the file has an ANALYZE header, or a NIfTI header without its identifier"
                               : "the identifier of the NIfTI header is wrong",
                           path, shown(fields.magic), "convert the image to NIfTI");
    }
    header.single_file = fields.magic == single;
    return Nothing{};
}

Status check_dim(const NiftiFields& fields, NiftiHeader& header, const std::string& path) {
    const std::int64_t axes = fields.dim[0];
    if (axes < 1 || axes > 7)
        return image_error("E-NII-004", "dim[0], the number of axes, is not 1 to 7", path,
                           fmt::format("{}", axes), "correct the header of the image");
    std::optional<std::uint64_t> volumes = 1;
    for (std::size_t axis = 1; axis <= static_cast<std::size_t>(axes); ++axis) {
        if (fields.dim[axis] < 1)
            return image_error("E-NII-004", fmt::format("dim[{}] is less than 1", axis), path,
                               fmt::format("{}", fields.dim[axis]), "correct the header of the image");
        const auto size = static_cast<std::uint64_t>(fields.dim[axis]);
        if (axis <= 3)
            header.layout.sizes[axis - 1] = size;
        else if (volumes)
            volumes = checked_multiply(*volumes, size);
    }
    if (!volumes)
        return image_error("E-NII-004", "the number of volumes does not fit 64 bits", path, "",
                           "correct the header of the image");
    header.layout.volumes = *volumes;
    return Nothing{};
}

Status check_type(const NiftiFields& fields, NiftiHeader& header, const std::string& path) {
    const auto known = std::find_if(data_types.begin(), data_types.end(),
                                    [&](const DataType& type) { return type.code == fields.datatype; });
    if (known == data_types.end() || !known->type)
        return image_error("E-NII-005",
                           fmt::format("voxels of type {} are not supported",
                                       known == data_types.end() ? "unknown" : known->name),
                           path, fmt::format("datatype {}", fields.datatype),
                           "convert the image to one integer or floating-point number a voxel");
    if (fields.bitpix != known->bits)
        return image_error("E-NII-006", fmt::format("bitpix contradicts the voxel type {}", known->name),
                           path, fmt::format("{}", fields.bitpix), "correct the header of the image");
    header.layout.type = *known->type;
    return Nothing{};
}

Status check_offset(const NiftiFields& fields, NiftiHeader& header, const std::string& path) {
    const double offset = fields.vox_offset;
    // A single file has at least the four extension bytes after the header.
    const auto least = static_cast<double>(header.single_file ? header.header_bytes() + 4 : 0);
    const bool usable = std::isfinite(offset) && offset >= least && offset <= 9007199254740992.0 &&
                        offset == std::floor(offset) && std::fmod(offset, 2) == 0;
    if (!usable)
        return image_error("E-NII-007", "vox_offset, where the data begins, is not possible", path,
                           fmt::format("{}", offset), "correct the header of the image");
    header.data_begin = static_cast<std::uint64_t>(offset);
    return Nothing{};
}

Status check_spacing(const NiftiFields& fields, NiftiHeader& header, const std::string& path,
                     RunContext& context) {
    switch (fields.units & 7) {
        case 1:
            header.millimetres = 1000;
            break;
        case 2:
            header.millimetres = 1;
            break;
        case 3:
            header.millimetres = 0.001;
            break;
        default:
            context.warn(image_warning("W-NII-002", "the image does not state its unit of length", path,
                                       fmt::format("xyzt_units {}", fields.units),
                                       "millimetres were assumed"));
    }
    const auto axes = static_cast<std::size_t>(fields.dim[0]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        header.pixdim[axis] = fields.pixdim[axis + 1];
        const double mm = header.pixdim[axis] * header.millimetres;
        header.axis_has_pixdim[axis] = mm >= 1e-6 && mm <= 1e6;
        // Beyond dim[0] the field has no meaning, and is looked at only where it is needed.
        if (axis < axes && !header.axis_has_pixdim[axis])
            return image_error("E-NII-008",
                               fmt::format("pixdim[{}], the voxel spacing, is not possible", axis + 1), path,
                               fmt::format("{}", header.pixdim[axis]), "correct the header of the image");
    }
    header.qfac = fields.pixdim[0];
    if (header.qfac == 0) {
        header.qfac = 1;
        if (header.qform_code > 0)
            context.warn(image_warning("W-NII-001", "pixdim[0], the handedness of the qform, is 0", path, "0",
                                       "it was read as 1"));
    } else if (std::abs(header.qfac) != 1) {
        return image_error("E-NII-009", "pixdim[0], the handedness of the qform, is neither 1 nor -1", path,
                           fmt::format("{}", header.qfac), "correct the header of the image");
    }
    return Nothing{};
}

Status check_scale(const NiftiFields& fields, NiftiHeader& header, const std::string& path) {
    if (!std::isfinite(fields.slope) || !std::isfinite(fields.intercept))
        return image_error("E-NII-010", "scl_slope or scl_inter is not finite", path,
                           fmt::format("{}, {}", fields.slope, fields.intercept),
                           "correct the header of the image");
    if (fields.slope != 0) {  // 0 says: not scaled
        header.slope = fields.slope;
        header.intercept = fields.intercept;
    }
    return Nothing{};
}

}  // namespace

Result<NiftiHeader> parse_nifti_header(std::span<const std::byte> bytes, const std::string& path,
                                       RunContext& context) {
    NiftiHeader header;
    const auto version = version_of(ByteReader(bytes));
    if (!version)
        return image_error("E-NII-002", "the header size is neither 348 nor 540", path, "",
                           "correct the header of the image");
    header.version = version->first;
    header.order = version->second;
    if (bytes.size() < header.header_bytes())
        return image_error("E-NII-001",
                           fmt::format("the file ends in its header, after {} of {} bytes", bytes.size(),
                                       header.header_bytes()),
                           path, "", "copy or export the image again");
    const ByteReader reader(bytes, header.order);
    const NiftiFields fields =
        header.version == 1 ? fields_of_version_1(reader) : fields_of_version_2(reader);
    header.qform_code = fields.qform_code;
    header.sform_code = fields.sform_code;
    header.quaternion = fields.quaternion;
    header.qoffset = {fields.qoffset[0], fields.qoffset[1], fields.qoffset[2]};
    header.srow = fields.srow;
    ANATOMESH_CHECK_STATUS(check_magic(fields, header, path));
    ANATOMESH_CHECK_STATUS(check_dim(fields, header, path));
    ANATOMESH_CHECK_STATUS(check_type(fields, header, path));
    ANATOMESH_CHECK_STATUS(check_offset(fields, header, path));
    ANATOMESH_CHECK_STATUS(check_spacing(fields, header, path, context));
    ANATOMESH_CHECK_STATUS(check_scale(fields, header, path));
    return header;
}

}  // namespace anatomesh
