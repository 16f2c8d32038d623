#include "read_input.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>

#include "anatomesh/contour/clean/clean.h"
#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/contour/simplify/simplify.h"
#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/image/components.h"
#include "anatomesh/image/select.h"
#include "anatomesh/image/threshold.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/image/tracked_frames.h"
#include "dicom_input.h"
#include "mesh_input.h"
#include "plural.h"
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

std::string number_text(double value) {
    std::string text;
    append_number(text, value);
    return text;
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
    const std::string why = fmt::format("the input is of the kind {}", name_of(kind));
    const std::pair<const char*, bool> of_dicom[] = {
        {"--series", !options.series.empty()},
        {"--allow-gaps", options.allow_gaps},
        {"--ignore-frame-of-reference", options.ignore_frame_of_reference},
        {"--ignore-patient", options.ignore_patient},
        {"--match-by-geometry", options.match_by_geometry},
        {"--allow-outside", options.allow_outside},
        {"--ultrasound-region", options.ultrasound_region.has_value()},
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
    const std::string why = image ? fmt::format("the input is of the kind {}", name_of(kind))
                                  : "the input holds contours, not an image";
    if (kind != FileKind::nifti) {
        if (!options.nifti_transform.empty()) return does_not_apply("--use", options.input, why);
        if (!options.assume_orientation.empty())
            return does_not_apply("--assume-orientation", options.input, why);
    }
    if (!image && options.volume && kind != FileKind::guide_points)
        return does_not_apply("--volume", options.input, why);
    ANATOMESH_CHECK_STATUS(check_special_options(options, kind));
    if (image && !options.cleaning_given.empty()) {
        return does_not_apply(options.cleaning_given.front(), options.input,
                              "the input is an image, whose contours are traced and not drawn");
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
        context.warn({"W-CMD-003", message, {options.input, "", "", "", option + " " + value}, "not used"});
    };
    if (!options.frame.empty() && !is_tracked && !has_warning(context, {"W-NRD-003", "W-MTI-002"}))
        warn("--frame", options.frame, "the image states its own axes");
    if (!options.assume_orientation.empty() && !has_warning(context, {"W-NII-005"}))
        warn("--assume-orientation", options.assume_orientation, "the image states its own orientation");
}

Result<OpenedInput> open_image(const InputOptions& options, FileKind kind, RunContext& context) {
    ANATOMESH_TRY(LoadedImage image, read_image(options.input, image_options(options), context));
    if (image.poses.empty()) {
        const std::string why = "the image is no tracked sequence";
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
    if (options.threshold) {
        if (looks_like_label_map(image.facts)) {
            context.warn({"W-CMD-002",
                          "the image looks like a label map",
                          {options.input, "", "", "", "--threshold"},
                          "taken as a grey image because of --threshold: its structures become one"});
        }
        return threshold_image(image.image, {options.threshold->low, options.threshold->high}, context);
    }
    if (!looks_like_label_map(image.facts)) {
        return input_usage_error("E-CMD-007", "this is a grey image, which needs a threshold", options.input,
                                 fmt::format("give --threshold LO[:HI]; the values run from {} to {}",
                                             number_text(image.facts.low), number_text(image.facts.high)));
    }
    return to_label_map(image, context);
}

TraceOptions tracing_options(const InputOptions& options) {
    TraceOptions tracing;
    tracing.every = options.every.value_or(1);
    tracing.offset = options.offset;
    if (options.min_area_mm2) tracing.min_area_mm2 = *options.min_area_mm2;
    if (options.epsilon_mm) tracing.epsilon_mm = *options.epsilon_mm;
    return tracing;
}

Status trace_layer(const LabelMap& labels, const GreyImage* grey, const InputOptions& options,
                   std::vector<TraceResult>& layers, RunContext& context) {
    const TraceOptions tracing = tracing_options(options);
    ANATOMESH_TRY(
        TraceResult traced,
        trace_contours(labels, grey, options.threshold ? options.threshold->low : 0, tracing, context));
    layers.push_back(std::move(traced));
    return Nothing{};
}

// Requires: at least one layer.
Result<InputContours> traced_contours(std::vector<TraceResult> layers, const InputOptions& options,
                                      std::vector<InputReport> files) {
    InputContours result;
    result.files = std::move(files);
    result.hole_rule = "a pixel of no structure inside one is a hole";
    std::vector<ContourSet> sets;
    for (TraceResult& layer : layers) {
        result.traced_points += layer.stats.points_traced;
        result.islands_left_out += layer.stats.islands_left_out;
        result.epsilon_mm = layer.stats.epsilon_mm;
        sets.push_back(std::move(layer.kept));
    }
    result.kept = merge_layers(std::move(sets));
    ANATOMESH_TRY(result.kept, without_slices(std::move(result.kept), options.without));
    const double pixel = result.kept.pixel_mm;
    result.options.emplace_back("min_area_mm2",
                                number_text(options.min_area_mm2.value_or(4 * pixel * pixel)));
    return result;
}

Result<InputContours> contours_of_image(OpenedInput input, const InputOptions& options, RunContext& context) {
    ANATOMESH_TRY(LabelMap labels, labels_of(*input.image, options, context));
    ANATOMESH_TRY(const auto chosen, find_structures(labels.structures, options.structures, options.input));
    if (chosen.size() < labels.structures.size()) select_structures(labels, chosen);
    const GreyImage* grey = options.threshold ? &input.image->image : nullptr;
    std::vector<TraceResult> layers;
    if (!input.image->poses.empty()) {
        ANATOMESH_TRY(
            TraceResult traced,
            trace_frames(labels, input.image->poses, input.image->known_axes ? Frame::lps : Frame::unknown,
                         grey, options.threshold ? options.threshold->low : 0,
                         options.keep_largest.value_or(0), tracing_options(options), context));
        layers.push_back(std::move(traced));
        return traced_contours(std::move(layers), options, std::move(input.files));
    }
    if (options.keep_largest) keep_largest(labels, *options.keep_largest);
    if (context.cancelled()) return cancelled_error();
    ANATOMESH_CHECK_STATUS(trace_layer(labels, grey, options, layers, context));
    return traced_contours(std::move(layers), options, std::move(input.files));
}

// Layers are traced one by one; a structure lies in one of them.
Result<InputContours> contours_of_segmentation(OpenedInput input, const InputOptions& options,
                                               RunContext& context) {
    const char* why = "the input is a segmentation";
    if (options.threshold) return does_not_apply("--threshold", options.input, why);
    std::vector<LabelMap>& maps = input.segmentation->layers;
    std::vector<Structure> all;
    for (const LabelMap& map : maps) all.insert(all.end(), map.structures.begin(), map.structures.end());
    ANATOMESH_TRY(const auto chosen, find_structures(all, options.structures, options.input));
    std::vector<TraceResult> layers;
    std::uint32_t first = 0;
    for (LabelMap& map : maps) {
        std::vector<std::uint32_t> own;
        for (const std::uint32_t index : chosen)
            if (index >= first && index - first < map.structures.size()) own.push_back(index - first);
        first += static_cast<std::uint32_t>(map.structures.size());
        if (own.empty()) continue;
        if (own.size() < map.structures.size()) select_structures(map, own);
        if (options.keep_largest) keep_largest(map, *options.keep_largest);
        if (context.cancelled()) return cancelled_error();
        ANATOMESH_CHECK_STATUS(trace_layer(map, nullptr, options, layers, context));
    }
    return traced_contours(std::move(layers), options, std::move(input.files));
}

// The contours of the chosen structures, everything else dropped.
RawContours chosen_contours(const RawContours& raw, const std::vector<std::uint32_t>& chosen) {
    constexpr std::uint32_t none = 0xFFFFFFFFu;
    std::vector<std::uint32_t> new_index(raw.structures.size(), none);
    RawContours out = raw;
    out.structures.clear();
    out.contours.clear();
    for (const std::uint32_t index : chosen) {
        new_index[index] = static_cast<std::uint32_t>(out.structures.size());
        out.structures.push_back(raw.structures[index]);
    }
    for (RawContour contour : raw.contours) {
        if (new_index[contour.structure] == none) continue;
        contour.structure = new_index[contour.structure];
        out.contours.push_back(std::move(contour));
    }
    return out;
}

// Contours of two frames of reference lie wherever each of these has its origin.
Status check_spaces(const RawContours& raw, const InputOptions& options, RunContext& context) {
    const auto told = [](const RawContour& contour) { return contour.space != 0; };
    const auto first = std::find_if(raw.contours.begin(), raw.contours.end(), told);
    const auto other = std::find_if(first, raw.contours.end(), [&](const RawContour& contour) {
        return told(contour) && contour.space != first->space;
    });
    if (other == raw.contours.end()) return Nothing{};
    const auto name = [&](const RawContour& contour) {
        const Structure& structure = raw.structures[contour.structure];
        return structure.name.empty() ? std::to_string(structure.number) : structure.name;
    };
    const std::string message =
        fmt::format("'{}' and '{}' are drawn in different frames of reference", name(*first), name(*other));
    const Place place{raw.source, "", name(*other), "", ""};
    if (options.ignore_frame_of_reference) {
        context.warn({"W-RTS-007", message, place, "taken for one, as --ignore-frame-of-reference has it"});
        return Nothing{};
    }
    return Error{ErrorKind::input, "E-RTS-010", message, place,
                 "choose structures of one frame with --structure, or take both as they are with "
                 "--ignore-frame-of-reference"};
}

std::vector<ContourReport> contour_log(const RawContours& raw, const CleanResult& cleaned) {
    std::vector<ContourReport> log;
    log.reserve(cleaned.log.size());
    for (const ContourLog& entry : cleaned.log) {
        const RawContour& contour = raw.contours[entry.raw_contour];
        const Structure& structure = raw.structures[contour.structure];
        ContourReport line;
        line.structure = structure.name.empty() ? std::to_string(structure.number) : structure.name;
        if (contour.plane >= 0 && static_cast<std::size_t>(contour.plane) < raw.plane_names.size()) {
            line.slice = raw.plane_names[static_cast<std::size_t>(contour.plane)];
        }
        line.name = contour.name;
        line.rule = entry.rule;
        line.points_in = entry.points_in;
        line.points_kept = entry.points_kept;
        line.max_displacement_mm = entry.max_displacement_mm;
        line.area_change_mm2 = entry.area_change_mm2;
        log.push_back(std::move(line));
    }
    return log;
}

Result<InputContours> contours_of_file(OpenedInput input, const InputOptions& options, RunContext& context) {
    const std::string why = "the input holds contours, not an image";
    if (options.threshold) return does_not_apply("--threshold", options.input, why);
    if (options.keep_largest) return does_not_apply("--keep-largest", options.input, why);
    if (options.min_area_mm2) return does_not_apply("--min-area", options.input, why);

    RawContours& all = *input.contours;
    ANATOMESH_TRY(const auto chosen, find_structures(all.structures, options.structures, options.input));
    const RawContours raw =
        chosen.size() < all.structures.size() ? chosen_contours(all, chosen) : std::move(all);
    ANATOMESH_CHECK_STATUS(check_spaces(raw, options, context));
    CleanOptions cleaning = options.cleaning;
    cleaning.without = options.without;
    if (options.epsilon_mm == 0.0) cleaning.crowded_mm = 0;
    ANATOMESH_TRY(CleanResult cleaned, clean_contours(raw, cleaning, context));

    InputContours result;
    result.files = std::move(input.files);
    result.log = contour_log(raw, cleaned);
    result.hole_rule = options.cleaning.holes == HoleRule::united
                           ? "filled: a contour inside another of its structure adds nothing"
                           : "even-odd: a contour inside another of its structure is a hole";
    result.traced_points = cleaned.stats.points_in;
    result.kept = std::move(cleaned.kept);
    if (options.every.value_or(1) > 1) {
        if (!all_parallel(result.kept, parallel_tolerance_mm)) {
            return does_not_apply("--every", options.input,
                                  "the slices are not parallel, so they have no order");
        }
        result.kept = every_nth_slice(result.kept, *options.every, options.offset);
        if (result.kept.contours.empty()) {
            return input_usage_error("E-CMD-008", "no slice is left after --every and --offset",
                                     options.input, "choose a smaller --every or --offset");
        }
    }
    if (options.epsilon_mm.value_or(0) > 0) {
        SimplifyOptions simplifying;
        simplifying.epsilon_mm = *options.epsilon_mm;
        ANATOMESH_TRY(SimplifyResult simplified, simplify_contours(result.kept, simplifying, context));
        result.kept = std::move(simplified.kept);
        result.epsilon_mm = *options.epsilon_mm;
    }
    if (options.as_drawn) return result;
    if (options.walls.close_gaps_mm > 0 && result.kept.structures.size() == 1)
        return does_not_apply("--close-gaps", options.input, "there is one structure alone");
    share_walls(result.kept, options.walls, context);
    result.options = {{"same_line_mm", number_text(options.walls.same_line_mm)},
                      {"close_slivers_mm", number_text(options.walls.close_slivers_mm)},
                      {"close_gaps_mm", number_text(options.walls.close_gaps_mm)}};
    return result;
}

// The options that say which part of the input was taken, as used.
std::vector<std::pair<std::string, std::string>> used_options(const InputOptions& options) {
    std::vector<std::pair<std::string, std::string>> used;
    if (!options.frame.empty()) used.emplace_back("frame", options.frame);
    if (!options.nifti_transform.empty()) used.emplace_back("use", options.nifti_transform);
    if (!options.assume_orientation.empty())
        used.emplace_back("assume_orientation", options.assume_orientation);
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
    if (!options.pose_to.empty()) used.emplace_back("pose_to", options.pose_to);
    if (!options.image_to_probe.empty()) {
        std::string matrix;
        for (const double value : options.image_to_probe)
            matrix += (matrix.empty() ? "" : " ") + number_text(value);
        used.emplace_back("image_to_probe", matrix);
    }
    if (options.structures.empty()) used.emplace_back("structure", "all");
    for (const std::string& name : options.structures) used.emplace_back("structure", name);
    for (const std::string& name : options.without) used.emplace_back("without", name);
    if (options.threshold) {
        const bool open = options.threshold->high == std::numeric_limits<double>::infinity();
        used.emplace_back("threshold", number_text(options.threshold->low) +
                                           (open ? "" : ":" + number_text(options.threshold->high)));
    }
    if (options.keep_largest) used.emplace_back("keep_largest", std::to_string(*options.keep_largest));
    used.emplace_back("every", std::to_string(options.every.value_or(1)));
    used.emplace_back("offset", std::to_string(options.offset));
    if (!options.cleaning_given.empty()) {
        const CleanOptions& cleaning = options.cleaning;
        used.emplace_back("holes", cleaning.holes == HoleRule::united ? "filled" : "even-odd");
        used.emplace_back("unite_repeated_planes", cleaning.unite_repeated_planes ? "yes" : "no");
        used.emplace_back("closing_gap_mm", number_text(cleaning.closing_gap_mm));
        used.emplace_back("plane_repair_mm", number_text(cleaning.plane_repair_mm));
        used.emplace_back("close_loops_mm2", number_text(cleaning.loop_mm2));
        used.emplace_back("max_repair_share", number_text(cleaning.max_repair_area_share));
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
        "inputs are NIfTI, NRRD, MetaImage, InVesalius projects, contour JSON, CSL, VTK polydata, DICOM "
        "images, RTSTRUCT and SEG, cardiac guide points, folders of DICOM objects, and folders of contours "
        "in VTK polydata";
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
            : fmt::format("the kind of the file is {}: neither an image nor contours", name_of(kind)),
        {options.input, "", "", "", ""},
        kinds};
}

Result<InputContours> contours_of(OpenedInput input, const InputOptions& options, RunContext& context) {
    if (options.offset >= options.every.value_or(1) && options.offset > 0) {
        return input_usage_error("E-CMD-008", "--offset must be less than --every", options.input,
                                 options.every ? "give a smaller --offset" : "give --every too");
    }
    auto source = std::move(input.dicom_source);
    const auto read = input.image          ? contours_of_image
                      : input.segmentation ? contours_of_segmentation
                                           : contours_of_file;
    ANATOMESH_TRY(InputContours result, read(std::move(input), options, context));
    result.dicom_source = std::move(source);
    auto used = used_options(options);
    used.insert(used.end(), result.options.begin(), result.options.end());
    used.emplace_back("epsilon_mm", result.epsilon_mm > 0 ? number_text(result.epsilon_mm)
                                    : options.epsilon_mm  ? "exact"
                                                          : "exact but for crowded points");
    result.options = std::move(used);
    return result;
}

Result<std::vector<std::uint32_t>> find_structures(const std::vector<Structure>& all,
                                                   const std::vector<std::string>& wanted,
                                                   const std::string& file) {
    std::vector<bool> taken(all.size(), wanted.empty());
    for (const std::string& text : wanted) {
        bool found = false;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].name == text) found = taken[i] = true;
        }
        const auto number = parse_integer<std::int32_t>(text);
        for (std::size_t i = 0; !found && number && i < all.size(); ++i) {
            if (all[i].number == *number) found = taken[i] = true;
        }
        if (found) continue;
        constexpr std::size_t most_listed = 100;
        std::vector<std::string> names;
        for (const Structure& each : all) {
            if (names.size() == most_listed) break;
            names.push_back(each.name.empty() ? fmt::format("{}", each.number)
                                              : fmt::format("{} ({})", each.name, each.number));
        }
        Error error = input_usage_error(
            "E-CMD-005", "there is no such structure", file,
            fmt::format("there are: {}{}", fmt::join(names, ", "), all.size() > most_listed ? ", ..." : ""));
        error.place.structure = text;
        return error;
    }
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (taken[i]) indices.push_back(static_cast<std::uint32_t>(i));
    }
    return indices;
}

Result<std::vector<std::uint32_t>> find_in_order(const std::vector<Structure>& all,
                                                 const std::vector<std::string>& wanted,
                                                 const std::string& file) {
    std::vector<std::uint32_t> order;
    for (const std::string& name : wanted) {
        ANATOMESH_TRY(const std::vector<std::uint32_t> found, find_structures(all, {name}, file));
        for (const std::uint32_t structure : found) {
            if (std::find(order.begin(), order.end(), structure) == order.end()) order.push_back(structure);
        }
    }
    return order;
}

std::string unique_text(const std::vector<Structure>& all, std::uint32_t structure) {
    const Structure& own = all[structure];
    const auto has_name = [&](const Structure& each) { return each.name == own.name; };
    return own.name.empty() || std::count_if(all.begin(), all.end(), has_name) > 1
               ? fmt::format("{}", own.number)
               : own.name;
}

ContourSet every_nth_slice(const ContourSet& set, std::uint32_t every, std::uint32_t offset) {
    std::vector<std::uint32_t> slices;
    for (std::size_t s = offset; s < set.slices.size(); s += every)
        slices.push_back(static_cast<std::uint32_t>(s));
    return chosen_slices(set, slices);
}

}  // namespace anatomesh
