#include "read_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>

#include "anatomesh/base/plural.h"
#include "anatomesh/contour/model/find_structures.h"
#include "anatomesh/image/select.h"
#include "anatomesh/image/threshold.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/image/tracked_frames.h"
#include "dicom_input.h"
#include "mesh_input.h"
#include "report_names.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

Error input_usage_error(const char* code, std::string message, const std::string& file,
                        std::string next_step) {
    return {ErrorKind::usage, code, std::move(message), {file, "", "", "", ""}, std::move(next_step)};
}

Error does_not_apply(const std::string& option, const std::string& file, const std::string& why) {
    return input_usage_error("E-CMD-008", fmt::format("{} does not apply: {}", option, why), file,
                             fmt::format("leave out {}", option));
}

bool is_image(FileKind kind) {
    return kind == FileKind::nifti || kind == FileKind::nrrd || kind == FileKind::metaimage ||
           kind == FileKind::invesalius || kind == FileKind::dicom || kind == FileKind::dicom_segmentation;
}

bool is_dicom(FileKind kind) {
    return kind == FileKind::dicom || kind == FileKind::dicom_segmentation ||
           kind == FileKind::dicom_rtstruct;
}

bool is_contour_file(FileKind kind) {
    return kind == FileKind::contour_json || kind == FileKind::csl || kind == FileKind::vtk_polydata ||
           kind == FileKind::dicom_rtstruct || kind == FileKind::guide_points;
}

Result<InputReport> file_report(const std::string& path, const std::string& format,
                                const InputLimits& limits) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, limits));
    return InputReport{path, format, file.sha256(), file.bytes().size()};
}

// The files of a folder of contour files, in the order of their names.
Result<std::vector<InputReport>> folder_report(const std::string& folder, const InputLimits& limits) {
    std::vector<std::string> paths;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (at->is_regular_file(error) && at->path().extension() == ".vtp")
            paths.push_back(at->path().string());
    }
    std::sort(paths.begin(), paths.end());
    std::vector<InputReport> files;
    for (const std::string& path : paths) {
        ANATOMESH_TRY(InputReport report, file_report(path, name_of(FileKind::vtk_polydata), limits));
        files.push_back(std::move(report));
    }
    return files;
}

bool has_contour_file(const std::string& folder) {
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (at->path().extension() == ".vtp") return true;
    }
    return false;
}

ReadImageOptions image_options(const InputOptions& options) {
    ReadImageOptions reading;
    if (options.frame == "LPS") reading.frame = ImageFrame::lps;
    if (options.frame == "RAS") reading.frame = ImageFrame::ras;
    if (options.nifti_transform == "qform") reading.nifti_transform = NiftiTransform::qform;
    if (options.nifti_transform == "sform") reading.nifti_transform = NiftiTransform::sform;
    reading.assume_orientation = options.assume_orientation;
    if (options.volume) reading.volume = *options.volume;
    reading.tracked = true;
    reading.image_to_probe = options.image_to_probe;
    reading.pose_to = options.pose_to;
    reading.limits = options.limits.input;
    reading.max_voxels = options.limits.voxels;
    return reading;
}

// Options of DICOM objects and tracked sequences, for files of other kinds.
Status check_special_options(const InputOptions& options, FileKind kind) {
    const std::string why = fmt::format("the kind of the input is {}", name_of(kind));
    const std::pair<const char*, bool> of_dicom[] = {
        {"--series", !options.series.empty()},
        {"--allow-gaps", options.allow_gaps},
        {"--ignore-frame-of-reference", options.ignore_frame_of_reference},
        {"--ignore-patient", options.ignore_patient},
        {"--match-by-geometry", options.match_by_geometry},
        {"--allow-outside", options.allow_outside},
        {"--ultrasound-region", options.ultrasound_region.has_value()},
        {"--frame-step", options.frame_step_mm.has_value()},
        {"--keep-patient-ids", options.keep_patient_ids}};
    for (const auto& [option, given] : of_dicom) {
        if (given && !is_dicom(kind)) return does_not_apply(option, options.input, why);
    }
    if (kind == FileKind::metaimage || kind == FileKind::nrrd) return Nothing{};
    if (!options.image_to_probe.empty()) return does_not_apply("--image-to-probe", options.input, why);
    if (!options.pose_to.empty()) return does_not_apply("--pose-to", options.input, why);
    return Nothing{};
}

// Options that this kind of file has no use for at all.
Status check_reading_options(const InputOptions& options, FileKind kind) {
    const bool image = is_image(kind);
    const std::string why = image ? fmt::format("the kind of the input is {}", name_of(kind))
                                  : "the input holds contours, not an image";
    if (kind != FileKind::nifti) {
        if (!options.nifti_transform.empty()) return does_not_apply("--use", options.input, why);
        if (!options.assume_orientation.empty())
            return does_not_apply("--assume-orientation", options.input, why);
    }
    if (!image && options.volume && kind != FileKind::guide_points)
        return does_not_apply("--volume", options.input, why);
    if (image && options.unit_mm) return does_not_apply("--unit", options.input, why);
    if (options.unit_mm && (kind == FileKind::contour_json || kind == FileKind::vtk_polydata))
        return does_not_apply("--unit", options.input, "files of this kind are in mm");
    ANATOMESH_CHECK_STATUS(check_special_options(options, kind));
    if (image && !options.cleaning_given.empty()) {
        return does_not_apply(options.cleaning_given.front(), options.input,
                              "the input is an image, not drawn contours");
    }
    return Nothing{};
}

bool has_warning(const RunContext& context, std::initializer_list<const char*> codes) {
    return std::any_of(context.warnings.begin(), context.warnings.end(), [&](const Warning& warning) {
        return std::find(codes.begin(), codes.end(), warning.code) != codes.end();
    });
}

// Options that decide what an image leaves open, given for one that leaves nothing open: scripts pass them
// always.
void warn_of_unused_options(const InputOptions& options, bool is_tracked, RunContext& context) {
    const auto warn = [&](const std::string& option, const std::string& value, const char* message) {
        context.warn({"W-CMD-003",
                      message,
                      {options.input, "", "", "", option + " " + value},
                      "the option was not used"});
    };
    if (!options.frame.empty() && !is_tracked && !has_warning(context, {"W-NRD-003", "W-MTI-002"}))
        warn("--frame", options.frame, "the image states its own axes");
    if (!options.assume_orientation.empty() && !has_warning(context, {"W-NII-005"}))
        warn("--assume-orientation", options.assume_orientation, "the image states its own orientation");
}

Result<OpenedInput> open_image(const InputOptions& options, FileKind kind, RunContext& context) {
    ANATOMESH_TRY(LoadedImage image, read_image(options.input, image_options(options), context));
    if (image.poses.empty()) {
        const std::string why = "the image is not a tracked sequence";
        if (!options.image_to_probe.empty()) return does_not_apply("--image-to-probe", options.input, why);
        if (!options.pose_to.empty()) return does_not_apply("--pose-to", options.input, why);
    }
    OpenedInput opened;
    opened.kind = kind;
    for (const InputHash& hash : image.inputs) {
        std::error_code error;
        const auto bytes = fs::file_size(hash.path, error);
        opened.files.push_back({hash.path, name_of(kind), hash.sha256, error ? 0 : bytes});
    }
    warn_of_unused_options(options, !image.poses.empty(), context);
    opened.image = std::move(image);
    return opened;
}

Result<OpenedInput> open_contours(const InputOptions& options, FileKind kind, bool folder,
                                  RunContext& context) {
    ReadContoursOptions reading;
    if (options.frame == "LPS") reading.frame = FrameChoice::lps;
    if (options.frame == "RAS") reading.frame = FrameChoice::ras;
    if (options.volume) reading.time_frame = *options.volume;
    reading.limits = options.limits.contour;
    reading.file_limits = options.limits.input;
    reading.unit_mm = options.unit_mm;
    ANATOMESH_TRY(RawContours raw, read_contours(options.input, reading, context));
    OpenedInput opened;
    opened.kind = kind;
    opened.contours = std::move(raw);
    if (folder) {
        ANATOMESH_TRY(opened.files, folder_report(options.input, options.limits.input));
    } else {
        ANATOMESH_TRY(InputReport report, file_report(options.input, name_of(kind), options.limits.input));
        opened.files.push_back(std::move(report));
    }
    return opened;
}

// A grey image needs a threshold; a label map is one already.
Result<LabelMap> labels_of(const LoadedImage& image, const InputOptions& options, RunContext& context) {
    if (options.prepare.label_maps.threshold) {
        if (looks_like_label_map(image.facts)) {
            context.warn(
                {"W-CMD-002",
                 "the image looks like a label map",
                 {options.input, "", "", "", "--threshold"},
                 "it was read as a grey image because of --threshold, so that its structures become one"});
        }
        return threshold_image(
            image.image,
            {options.prepare.label_maps.threshold->low, options.prepare.label_maps.threshold->high}, context);
    }
    if (!looks_like_label_map(image.facts)) {
        return input_usage_error("E-CMD-007", "the image is a grey image, which needs --threshold",
                                 options.input,
                                 fmt::format("give --threshold LO[:HI]; the values run from {} to {}",
                                             number_text(image.facts.low), number_text(image.facts.high)));
    }
    return to_label_map(image, context);
}

// Frames that each have a pose are traced one by one.
Result<PreparedContours> contours_of_frames(LabelMap labels, const LoadedImage& image, const GreyImage* grey,
                                            const PrepareOptions& prepare, RunContext& context,
                                            const ContoursCheck& check) {
    const std::string why = "each frame of the sequence is a slice";
    if (prepare.label_maps.axis) return does_not_apply("--axis", prepare.input, why);
    if (prepare.label_maps.between_sparse != BetweenSparse::nothing)
        return does_not_apply("--between-sparse", prepare.input, why);
    ANATOMESH_TRY(const auto chosen,
                  find_structures(labels.structures, prepare.choice.structures, prepare.input));
    if (chosen.size() < labels.structures.size()) select_structures(labels, chosen);
    std::vector<TraceResult> layers;
    ANATOMESH_TRY(TraceResult traced,
                  trace_frames(labels, image.poses, image.known_axes ? Frame::lps : Frame::unknown, grey,
                               prepare.label_maps.threshold ? prepare.label_maps.threshold->low : 0,
                               prepare.label_maps.keep_largest.value_or(0), trace_options(prepare), context));
    layers.push_back(std::move(traced));
    return prepare_contours(std::move(layers), prepare, context, check);
}

Result<PreparedContours> contours_of_image(OpenedInput& input, const InputOptions& options,
                                           const PrepareOptions& prepare, RunContext& context,
                                           const ContoursCheck& check) {
    const LoadedImage& image = *input.image;
    ANATOMESH_TRY(LabelMap labels, labels_of(image, options, context));
    const GreyImage* grey = prepare.label_maps.threshold ? &image.image : nullptr;
    if (!image.poses.empty())
        return contours_of_frames(std::move(labels), image, grey, prepare, context, check);
    std::vector<LabelMap> layers;
    layers.push_back(std::move(labels));
    PrepareOptions of_image = prepare;
    of_image.label_maps.frame = image.known_axes ? Frame::lps : Frame::unknown;
    return prepare_contours(std::move(layers), grey, of_image, context, check);
}

Result<PreparedContours> contours_of_segmentation(OpenedInput& input, const InputOptions& options,
                                                  const PrepareOptions& prepare, RunContext& context,
                                                  const ContoursCheck& check) {
    if (prepare.label_maps.threshold)
        return does_not_apply("--threshold", options.input, "the input is a segmentation");
    PrepareOptions of_segmentation = prepare;
    of_segmentation.label_maps.frame = input.segmentation->known_axes ? Frame::lps : Frame::unknown;
    return prepare_contours(std::move(input.segmentation->layers), nullptr, of_segmentation, context, check);
}

Result<PreparedContours> contours_of_file(OpenedInput& input, const InputOptions& options,
                                          const PrepareOptions& prepare, RunContext& context,
                                          const ContoursCheck& check) {
    const std::string why = "the input holds contours, not an image";
    if (prepare.label_maps.threshold) return does_not_apply("--threshold", options.input, why);
    if (prepare.label_maps.keep_largest) return does_not_apply("--keep-largest", options.input, why);
    if (prepare.label_maps.min_area_mm2) return does_not_apply("--min-area", options.input, why);
    if (prepare.label_maps.axis) return does_not_apply("--axis", options.input, why);
    if (prepare.label_maps.between_sparse != BetweenSparse::nothing)
        return does_not_apply("--between-sparse", options.input, why);
    return prepare_contours(*input.contours, prepare, context, check);
}

// The options that say how the input was read.
std::vector<std::pair<std::string, std::string>> reading_told(const InputOptions& options) {
    std::vector<std::pair<std::string, std::string>> used;
    if (!options.frame.empty()) used.emplace_back("frame", options.frame);
    if (!options.nifti_transform.empty()) used.emplace_back("use", options.nifti_transform);
    if (!options.assume_orientation.empty())
        used.emplace_back("assume_orientation", options.assume_orientation);
    if (options.unit_mm) used.emplace_back("unit_mm", number_text(*options.unit_mm));
    if (options.volume) used.emplace_back("volume", std::to_string(*options.volume));
    if (!options.series.empty())
        used.emplace_back("series", options.keep_patient_ids ? options.series : shown_series(options.series));
    const std::pair<const char*, bool> flags[] = {
        {"allow_gaps", options.allow_gaps},
        {"ignore_frame_of_reference", options.ignore_frame_of_reference},
        {"ignore_patient", options.ignore_patient},
        {"match_by_geometry", options.match_by_geometry},
        {"allow_outside", options.allow_outside}};
    for (const auto& [name, given] : flags)
        if (given) used.emplace_back(name, "yes");
    if (options.ultrasound_region)
        used.emplace_back("ultrasound_region", std::to_string(*options.ultrasound_region));
    if (options.frame_step_mm) used.emplace_back("frame_step_mm", number_text(*options.frame_step_mm));
    if (!options.pose_to.empty()) used.emplace_back("pose_to", options.pose_to);
    if (!options.image_to_probe.empty()) {
        std::string matrix;
        for (const double value : options.image_to_probe)
            matrix += (matrix.empty() ? "" : " ") + number_text(value);
        used.emplace_back("image_to_probe", matrix);
    }
    return used;
}

}  // namespace

std::vector<std::string> names_of(const std::vector<InputReport>& files) {
    std::vector<std::string> names;
    for (const InputReport& file : files) names.push_back(file.file);
    return names;
}

bool is_dicom_folder(const std::string& path) {
    std::error_code error;
    return fs::is_directory(path, error) && !has_contour_file(path);
}

Result<OpenedInput> open_input(const InputOptions& options, RunContext& context) {
    constexpr const char* kinds =
        "give NIfTI, NRRD, MetaImage, an InVesalius project, contour JSON, CSL, VTK polydata, DICOM images, "
        "RTSTRUCT "
        "or SEG, cardiac guide points, or a folder of DICOM objects or VTK polydata";
    std::error_code error;
    if (fs::is_directory(options.input, error)) {
        if (!has_contour_file(options.input)) {
            ANATOMESH_CHECK_STATUS(check_special_options(options, FileKind::dicom));
            return open_dicom(options, context);
        }
        ANATOMESH_CHECK_STATUS(check_reading_options(options, FileKind::vtk_polydata));
        return open_contours(options, FileKind::vtk_polydata, true, context);
    }
    ANATOMESH_TRY(const FileKind kind, detect(options.input));
    if (is_image(kind) || is_contour_file(kind)) {
        ANATOMESH_CHECK_STATUS(check_reading_options(options, kind));
    }
    if (kind == FileKind::dicom || kind == FileKind::dicom_segmentation) return open_dicom(options, context);
    if (is_image(kind)) return open_image(options, kind, context);
    if (kind == FileKind::dicom_rtstruct) warn_of_absent_images(options, context);
    if (is_contour_file(kind)) return open_contours(options, kind, false, context);
    return Error{
        ErrorKind::input,
        "E-CMD-012",
        kind == FileKind::unknown
            ? unknown_content(options.input)
            : fmt::format("the file is neither an image nor contours; its kind is {}", name_of(kind)),
        {options.input, "", "", "", ""},
        kinds};
}

Result<InputContours> contours_of(OpenedInput input, const InputOptions& options, RunContext& context,
                                  const ContoursCheck& check) {
    PrepareOptions prepare = options.prepare;
    prepare.input = options.input;
    prepare.take_spaces_for_one = options.ignore_frame_of_reference;
    prepare.name_cleaning = !options.cleaning_given.empty();
    if (prepare.choice.offset >= prepare.choice.every.value_or(1) && prepare.choice.offset > 0) {
        return input_usage_error("E-CMD-008", "--offset must be less than --every", options.input,
                                 prepare.choice.every ? "give a smaller --offset" : "give --every too");
    }
    const auto read = input.image          ? contours_of_image
                      : input.segmentation ? contours_of_segmentation
                                           : contours_of_file;
    ANATOMESH_TRY(PreparedContours prepared, read(input, options, prepare, context, check));
    const auto told = reading_told(options);
    prepared.options.insert(prepared.options.begin(), told.begin(), told.end());
    return InputContours{std::move(prepared), std::move(input.files), std::move(input.dicom_source)};
}

}  // namespace anatomesh
