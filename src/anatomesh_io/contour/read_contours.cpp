#include "anatomesh_io/contour/read_contours.h"

#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "anatomesh_io/contour/csl_reader.h"
#include "anatomesh_io/contour/dicom_layout.h"
#include "anatomesh_io/contour/guide_points_reader.h"
#include "anatomesh_io/contour/json_reader.h"
#include "anatomesh_io/contour/raw_builder.h"
#include "anatomesh_io/contour/rtstruct_reader.h"
#include "anatomesh_io/contour/vtp_contours.h"
#include "anatomesh_io/file/detect.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

namespace {

FileFrame file_frame(FrameChoice choice) {
    return choice == FrameChoice::lps   ? FileFrame::lps
           : choice == FrameChoice::ras ? FileFrame::ras
                                        : FileFrame::unknown;
}

Status read_content(const InputFile& file, const ReadContoursOptions& options, RawBuilder& builder) {
    const std::span<const std::byte> bytes = file.bytes();
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const FileKind kind = detect_bytes(bytes);
    switch (kind) {
        case FileKind::dicom_rtstruct:
            return read_rtstruct(text, builder);
        case FileKind::csl:
            return read_csl(text, builder);
        case FileKind::guide_points:
            return read_guide_points(text, options.time_frame, builder);
        case FileKind::contour_json:
            return read_json_contours(text, builder);
        case FileKind::vtk_polydata:
            return read_vtp_contours(bytes, file.path, "", 1, options.file_limits, builder);
        default:
            break;
    }
    return Error{
        ErrorKind::input,
        "E-CIO-008",
        bytes.empty() ? "the file is empty" : std::string("contours are expected, not: ") + name_of(kind),
        {file.path, {}, {}, {}, {}},
        "give contours as JSON (anatomesh-contours), CSL, VTK XML polydata (.vtp) or DICOM RTSTRUCT"};
}

}  // namespace

Result<RawContours> read_contours(const std::string& path, const ReadContoursOptions& options,
                                  RunContext& context) {
    RawBuilder builder(path, options.limits, context);
    builder.unit_is_given = options.unit_mm.has_value();
    std::error_code unknown;
    if (std::filesystem::is_directory(path, unknown)) {
        ANATOMESH_CHECK_STATUS(read_vtp_folder(path, options.file_limits, builder));
    } else {
        ANATOMESH_TRY(const InputFile file, read_input_file(path, options.file_limits));
        ANATOMESH_CHECK_STATUS(read_content(file, options, builder));
    }
    ANATOMESH_TRY(RawContours raw, builder.finish(file_frame(options.frame)));
    const double unit = options.unit_mm.value_or(1);
    if (unit == 1) return raw;
    for (Vec3& point : raw.points) point = unit * point;
    for (Plane& plane : raw.planes) plane.origin = unit * plane.origin;
    raw.pixel_mm *= unit;
    raw.slice_thickness_mm *= unit;
    return raw;
}

}  // namespace anatomesh
