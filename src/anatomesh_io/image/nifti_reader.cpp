#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/image/nifti_header.h"
#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

// Geometry in RAS and the file's unit, before it is turned and scaled.
Result<ImageGeometry> qform_geometry(const NiftiHeader& header, const std::string& path) {
    const auto [b, c, d] = header.quaternion;
    const double squared = b * b + c * c + d * d;
    if (!(squared <= 1.001))
        return image_error("E-NII-011", "the quaternion of the qform is longer than 1", path,
                           fmt::format("{}, {}, {}", b, c, d), "choose the other transform with --use sform");
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!header.axis_has_pixdim[axis])
            return image_error("E-NII-008",
                               fmt::format("pixdim[{}], the voxel spacing, is not possible", axis + 1), path,
                               fmt::format("{}", header.pixdim[axis]), "correct the header of the image");
    // nifti1.h, "QUATERNION REPRESENTATION OF ROTATION MATRIX"; a rotation by 180 degrees has a = 0.
    double a = 1 - squared, scale = 1;
    if (a < 1e-7) {
        scale = 1 / std::sqrt(squared);
        a = 0;
    } else {
        a = std::sqrt(a);
    }
    const double x = b * scale, y = c * scale, z = d * scale;
    ImageGeometry geometry;
    geometry.origin = header.qoffset;
    geometry.step[0] =
        header.pixdim[0] * Vec3{a * a + x * x - y * y - z * z, 2 * (x * y + a * z), 2 * (x * z - a * y)};
    geometry.step[1] =
        header.pixdim[1] * Vec3{2 * (x * y - a * z), a * a + y * y - x * x - z * z, 2 * (y * z + a * x)};
    geometry.step[2] = header.qfac * header.pixdim[2] *
                       Vec3{2 * (x * z + a * y), 2 * (y * z - a * x), a * a + z * z - y * y - x * x};
    return geometry;
}

ImageGeometry sform_geometry(const NiftiHeader& header) {
    const auto& [x, y, z] = header.srow;
    ImageGeometry geometry;
    for (std::size_t axis = 0; axis < 3; ++axis) geometry.step[axis] = {x[axis], y[axis], z[axis]};
    geometry.origin = {x[3], y[3], z[3]};
    return geometry;
}

void to_lps_millimetres(const NiftiHeader& header, ImageGeometry& geometry) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        geometry.size[axis] = static_cast<std::uint32_t>(header.layout.sizes[axis]);
    if (header.millimetres != 1) {
        geometry.origin = header.millimetres * geometry.origin;
        for (Vec3& step : geometry.step) step = header.millimetres * step;
    }
    turn_ras_lps(geometry);
}

double determinant(const ImageGeometry& g) {
    return dot(g.step[0], cross(g.step[1], g.step[2]));
}

// The farthest that a corner voxel of one lies from the same voxel of the other.
double largest_difference(const ImageGeometry& one, const ImageGeometry& other) {
    double largest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const auto end = [&](int axis) { return corner >> axis & 1 ? one.size[axis] - 1.0 : 0.0; };
        const Vec3 gap = one.position(end(0), end(1), end(2)) - other.position(end(0), end(1), end(2));
        largest = std::max(largest, length(gap));
    }
    return largest;
}

Result<ImageGeometry> reconciled(const ImageGeometry& qform, const ImageGeometry& sform,
                                 const std::string& path, const ReadImageOptions& options,
                                 RunContext& context) {
    // Both transforms agree if they place no corner further apart: they are stored as single floats.
    // [mm; 0 to 1; D digits of files]
    constexpr double tolerance_mm = 0.01;
    const double difference = largest_difference(qform, sform);
    const bool mirrored = (determinant(qform) > 0) != (determinant(sform) > 0);
    const bool agree = difference <= tolerance_mm && !mirrored;
    const bool take_qform = options.nifti_transform == NiftiTransform::qform;
    if (!agree && options.nifti_transform == NiftiTransform::automatic)
        return image_error("E-NII-012",
                           fmt::format("qform and sform place the image {:.4g} mm apart{}", difference,
                                       mirrored ? " and mirrored to each other" : ""),
                           path, fmt::format("{:.4g} mm", difference),
                           "choose one with --use qform or --use sform");
    if (!agree)
        context.warn(image_warning(
            "W-NII-004", fmt::format("qform and sform place the image {:.4g} mm apart", difference), path,
            fmt::format("{:.4g} mm", difference),
            take_qform ? "the qform was used, as chosen" : "the sform was used, as chosen"));
    return take_qform ? qform : sform;
}

// NIfTI without a transform ("method 1" of nifti1.h) says the spacing alone.
Result<ImageGeometry> assumed_geometry(const NiftiHeader& header, const std::string& path,
                                       const ReadImageOptions& options, RunContext& context) {
    if (options.assume_orientation.empty())
        return image_error("E-NII-013", "the image has no orientation (qform_code and sform_code are 0)",
                           path, "", "give it with --assume-orientation, for example RAS");
    ANATOMESH_TRY(const auto steps, orientation_steps(options.assume_orientation, path));
    ImageGeometry geometry;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        geometry.size[axis] = static_cast<std::uint32_t>(header.layout.sizes[axis]);
        if (!header.axis_has_pixdim[axis])
            return image_error("E-NII-008",
                               fmt::format("pixdim[{}], the voxel spacing, is not possible", axis + 1), path,
                               fmt::format("{}", header.pixdim[axis]), "correct the header of the image");
        geometry.step[axis] = header.pixdim[axis] * header.millimetres * steps[axis];
    }
    context.warn(image_warning(
        "W-NII-005", "the image has no orientation", path, "",
        "--assume-orientation " + options.assume_orientation + " was used, with voxel 0 at the origin"));
    return geometry;
}

Result<ImageGeometry> geometry_of(const NiftiHeader& header, const std::string& path,
                                  const ReadImageOptions& options, RunContext& context) {
    const bool has_qform = header.qform_code > 0, has_sform = header.sform_code > 0;
    if (header.qform_code < 0 || header.sform_code < 0)
        return image_error("E-NII-014", "qform_code or sform_code is negative", path,
                           fmt::format("{}, {}", header.qform_code, header.sform_code),
                           "correct the header of the image");
    if (!has_qform && !has_sform) return assumed_geometry(header, path, options, context);
    if (options.nifti_transform == NiftiTransform::qform && !has_qform)
        return image_error("E-NII-015", "the image has no qform", path, "", "choose --use sform");
    if (options.nifti_transform == NiftiTransform::sform && !has_sform)
        return image_error("E-NII-015", "the image has no sform", path, "", "choose --use qform");

    const bool use_qform = has_qform && options.nifti_transform != NiftiTransform::sform;
    const bool use_sform = has_sform && options.nifti_transform != NiftiTransform::qform;
    ImageGeometry sform = sform_geometry(header);
    to_lps_millimetres(header, sform);
    if (use_sform) {
        ANATOMESH_CHECK_STATUS(check_geometry(sform, path));
    }
    if (!has_qform) return sform;
    auto qform = qform_geometry(header, path);
    if (qform.ok()) to_lps_millimetres(header, qform.value());
    const Status qform_usable = qform.ok() ? check_geometry(qform.value(), path) : Status(qform.error());
    if (!qform_usable.ok()) {
        if (use_qform) return qform_usable.error();
        context.warn(image_warning("W-NII-004", "the qform cannot be used: " + qform_usable.error().message,
                                   path, "", "the sform was used, as chosen"));
        return sform;
    }
    if (!has_sform) return std::move(qform).value();
    return reconciled(qform.value(), sform, path, options, context);
}

// Extensions lie between header and data and are not needed; a chain of them that is broken is worth a word.
void check_extensions(const NiftiHeader& header, std::span<const std::byte> content, const std::string& path,
                      RunContext& context) {
    ByteReader reader(content.first(std::min<std::uint64_t>(content.size(), header.data_begin)),
                      header.order);
    if (!reader.seek(header.header_bytes()) || reader.remaining() <= 4) return;
    if (reader.read<std::uint8_t>().value_or(0) == 0) return;
    reader.skip(3);
    while (reader.remaining() >= 8) {
        const std::int32_t size = reader.read<std::int32_t>().value_or(0);
        if (size < 16 || size % 16 != 0 || !reader.skip(static_cast<std::uint64_t>(size) - 4)) {
            context.warn(image_warning("W-NII-003", "a header extension has an impossible size", path,
                                       fmt::format("{}", size), "the extensions were ignored"));
            return;
        }
    }
}

// The .img file beside a .hdr: same name, also compressed.
Result<InputFile> read_data_file(const std::string& path, const ReadImageOptions& options) {
    std::string stem = path;
    for (const char* ending : {".gz", ".hdr"})
        if (stem.size() > std::string_view(ending).size() && stem.ends_with(ending))
            stem.resize(stem.size() - std::string_view(ending).size());
    auto plain = read_input_file(stem + ".img", options.limits);
    if (plain.ok() || plain.error().code != "E-INP-001") return plain;
    auto compressed = read_input_file(stem + ".img.gz", options.limits);
    if (compressed.ok() || compressed.error().code != "E-INP-001") return compressed;
    return image_error("E-NII-016", "the header's data file is missing", path, stem + ".img",
                       "put the .img file beside the .hdr file");
}

// Sets raw.data to the bytes of the chosen volume within `content`.
Status choose_data(const NiftiHeader& header, std::uint64_t claimed, std::span<const std::byte> content,
                   const std::string& path, const ReadImageOptions& options, RunContext& context,
                   RawImage& raw) {
    ByteReader reader(content);
    if (!reader.seek(header.data_begin))
        return image_error("E-NII-007", "vox_offset lies beyond the end of the file", path,
                           fmt::format("{}", header.data_begin), "copy or export the image again");
    ANATOMESH_CHECK_STATUS(check_length(claimed, reader.remaining(), path, context));
    ANATOMESH_TRY(const std::uint64_t volume, chosen_volume(header.layout.volumes, path, options));
    const std::uint64_t volume_bytes = claimed / header.layout.volumes;
    raw.data = content.subspan(header.data_begin + volume * volume_bytes, volume_bytes);
    return Nothing{};
}

}  // namespace

Result<RawImage> read_nifti(const InputFile& file, const ReadImageOptions& options, RunContext& context) {
    // So many bytes tell the format and the size: the header of NIfTI-2 has 540, and four flags follow.
    // [bytes; 544; D NIfTI-2]
    constexpr std::size_t header_bytes = 544;
    const std::string& path = file.path;
    std::vector<std::byte> inflated_start;
    std::span<const std::byte> start = file.bytes();
    if (is_gzip(start)) start = inflated_start = inflate_start(start, header_bytes);
    ANATOMESH_TRY(const NiftiHeader header, parse_nifti_header(start, path, context));
    RawImage raw;
    raw.type = header.layout.type;
    raw.order = header.order;
    raw.slope = header.slope;
    raw.intercept = header.intercept;

    // The claim is held against the length of the file first where that is known: a lie is not a limit.
    const bool compressed = is_gzip(file.bytes());
    ReadImageOptions unlimited = options;
    if (!compressed && header.single_file) unlimited.max_voxels = ~std::uint64_t{0};
    ANATOMESH_TRY(const std::uint64_t claimed, claimed_bytes(header.layout, path, unlimited));

    InputFile data_file;
    std::span<const std::byte> content = file.bytes();
    if (!header.single_file) {
        ANATOMESH_TRY(data_file, read_data_file(path, options));
        raw.further_inputs.push_back({data_file.path, data_file.sha256()});
        content = data_file.bytes();
    }
    const std::string& data_path = header.single_file ? path : data_file.path;
    if (is_gzip(content)) {
        ANATOMESH_TRY(raw.storage,
                      inflate(content, data_path, options.limits, context, header.data_begin + claimed));
        content = raw.storage.bytes();
    } else if (!header.single_file) {
        raw.storage = std::move(data_file.content);
        content = raw.storage.bytes();
    }
    if (header.single_file) check_extensions(header, content, path, context);
    ANATOMESH_CHECK_STATUS(choose_data(header, claimed, content, data_path, options, context, raw));
    ANATOMESH_CHECK_STATUS(claimed_bytes(header.layout, path, options));
    ANATOMESH_TRY(raw.geometry, geometry_of(header, path, options, context));
    ANATOMESH_CHECK_STATUS(check_geometry(raw.geometry, path));
    return raw;
}

}  // namespace anatomesh
