#include "dicom_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/base/plural.h"
#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/dicom/choose.h"
#include "anatomesh_io/dicom/read_series.h"
#include "anatomesh_io/dicom/segmentation.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

DicomFolderOptions folder_options(const InputOptions& options) {
    DicomFolderOptions reading;
    reading.keep_names = options.keep_patient_ids;
    reading.limits = options.limits.input;
    reading.frames = {options.ultrasound_region, options.frame_step_mm};
    return reading;
}

ChooseOptions choose_options(const InputOptions& options) {
    return {options.ignore_frame_of_reference, options.ignore_patient, options.match_by_geometry};
}

InputReport report_of(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                      const std::string& format) {
    std::uint64_t bytes = 0;
    for (const std::uint32_t index : objects) bytes += folder.objects[index].bytes;
    const InputHash hash = hash_of(folder, objects);
    const std::string files = objects.size() > 1 ? fmt::format(", {} files", objects.size()) : "";
    return {hash.path, format + files, hash.sha256, bytes};
}

// The path of a file within a folder must not get out by messages of readers that know no better.
void hide_path(const DicomObject& object, RunContext& context) {
    for (Warning& warning : context.warnings)
        if (warning.place.file == object.path) warning.place.file = object.label;
}

Result<RawContours> contours_in(const DicomObject& object, const InputOptions& options, RunContext& context) {
    ReadContoursOptions reading;
    reading.limits = options.limits.contour;
    reading.file_limits = options.limits.input;
    reading.unit_mm = options.unit_mm;
    auto raw = read_contours(object.path, reading, context);
    hide_path(object, context);
    if (!raw.ok()) {
        Error error = raw.error();
        if (error.place.file == object.path) error.place.file = object.label;
        return error;
    }
    raw.value().source = object.label;
    return raw;
}

// The positions of images along a direction, in order, of those that are parallel to it within rounding.
std::vector<Vec3> positions_of_images(const DicomFolder& folder, const std::vector<std::uint32_t>& images,
                                      Vec3 normal) {
    // Directions agree within this, because files round cosines. [1; 0 to 0.1; D digits of files]
    constexpr double same_direction = 1e-3;
    std::vector<Vec3> positions;
    for (const std::uint32_t index : images) {
        if (!folder.objects[index].known_axes) continue;
        for (const DicomFrame& plane : folder.objects[index].planes) {
            const Vec3 other = cross(plane.row, plane.column);
            if (std::min(length(other - normal), length(other + normal)) < same_direction)
                positions.push_back(plane.position);
        }
    }
    return positions;
}

// Whether all contours lie in planes that are parallel to the first image.
bool lies_along_images(const RawContours& contours, const DicomFolder& folder,
                       const std::vector<std::uint32_t>& images) {
    if (images.empty() || folder.objects[images[0]].planes.empty() || !folder.objects[images[0]].known_axes)
        return false;
    const DicomFrame& first = folder.objects[images[0]].planes[0];
    const Vec3 normal = cross(first.row, first.column);
    // A contour that reaches further across the images lies in another plane. [mm; > 0; D digits of files]
    constexpr double flat_mm = 0.1;
    return std::all_of(contours.contours.begin(), contours.contours.end(), [&](const RawContour& contour) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (std::uint32_t p = 0; p < contour.point_count; ++p) {
            const double height = dot(contours.points[contour.first_point + p], normal);
            low = std::min(low, height);
            high = std::max(high, height);
        }
        return contour.point_count == 0 || high - low < flat_mm;
    });
}

// How thick the images say that a slice is: the median distance of their planes, if most are as far apart; else, as
// where only the images with contours are there, what they state if that is less. 0: nothing says it.
double thickness_of_images(const DicomFolder& folder, const std::vector<std::uint32_t>& images) {
    if (images.empty() || folder.objects[images[0]].planes.empty()) return 0;
    const DicomFrame& first = folder.objects[images[0]].planes[0];
    const Vec3 normal = cross(first.row, first.column);
    std::vector<double> heights;
    for (const Vec3& position : positions_of_images(folder, images, normal))
        heights.push_back(dot(position - first.position, normal));
    std::sort(heights.begin(), heights.end());
    std::vector<double> gaps;
    // Nearer images lie in one plane. [mm; > 0; D digits of files]
    constexpr double same_plane_mm = 1e-3;
    for (std::size_t n = 1; n < heights.size(); ++n)
        if (heights[n] - heights[n - 1] > same_plane_mm) gaps.push_back(heights[n] - heights[n - 1]);
    const double stated = std::max(0.0, folder.objects[images[0]].slice_thickness.value_or(0));
    if (gaps.empty()) return stated;
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    const double median = gaps[gaps.size() / 2];
    // Two gaps or more, of which two in three are alike, are the spacing of a series. [1; 0 to 1; D digits of files]
    constexpr double alike = 0.05;
    const auto as_usual = static_cast<std::size_t>(std::count_if(
        gaps.begin(), gaps.end(), [&](double gap) { return std::abs(gap - median) <= alike * median; }));
    const bool is_series = as_usual >= 2 && 3 * as_usual >= 2 * gaps.size();
    return is_series || stated == 0 ? median : std::min(median, stated);
}

Result<LoadedSegmentation> segmentation_in(const DicomFolder& folder, const DicomChoice& choice,
                                           const InputOptions& options, RunContext& context) {
    const DicomObject& object = folder.objects[choice.objects[0]];
    ANATOMESH_TRY(const InputFile file, read_input_file(object.path, options.limits.input));
    const std::string_view bytes(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
    ReadSegmentationOptions reading;
    reading.max_voxels = options.limits.voxels;
    if (!object.planes.empty())
        reading.image_positions =
            positions_of_images(folder, choice.images, cross(object.planes[0].row, object.planes[0].column));
    return read_dicom_segmentation(bytes, object.label, reading, context);
}

// The rims of a segmentation's planes that hold something, as contours.
RawContours outline_of(const LoadedSegmentation& loaded) {
    const ImageGeometry& geometry = loaded.layers[0].geometry;
    const std::size_t pixels = std::size_t{geometry.size[0]} * geometry.size[1];
    RawContours rims;
    rims.source = loaded.layers[0].source;
    for (std::uint32_t k = 0; k < geometry.size[2]; ++k) {
        const bool is_empty =
            std::all_of(loaded.layers.begin(), loaded.layers.end(), [&](const LabelMap& layer) {
                const auto first = layer.voxels.begin() + static_cast<std::ptrdiff_t>(k * pixels);
                return std::all_of(first, first + static_cast<std::ptrdiff_t>(pixels),
                                   [](auto v) { return v == 0; });
            });
        if (is_empty) continue;
        RawContour rim;
        rim.first_point = static_cast<std::uint32_t>(rims.points.size());
        rim.point_count = 4;
        const double i = geometry.size[0] - 1.0, j = geometry.size[1] - 1.0;
        for (const auto& [x, y] : {std::pair{0.0, 0.0}, {i, 0.0}, {i, j}, {0.0, j}})
            rims.points.push_back(geometry.position(x, y, k));
        rims.contours.push_back(std::move(rim));
    }
    return rims;
}

// Contours, or a segmentation's rims, beside the images that their object refers to, or that lie as it does.
// Returns whether all contours lie on images.
Result<bool> compare_with_images(const RawContours& contours, const DicomFolder& folder,
                                 const DicomObject& object, const DicomChoice& choice,
                                 const InputOptions& options, RunContext& context) {
    std::vector<std::uint32_t> images = choice.images;
    if (images.empty() && options.match_by_geometry) {
        ANATOMESH_TRY(images, match_images(contours, folder));
    }
    ANATOMESH_TRY(const bool are_on_images,
                  check_against_images(contours, folder, images,
                                       {options.allow_outside, options.unit_mm.has_value()}, context));
    if (images.empty() || object.kind != DicomKind::rtstruct) return are_on_images;
    ANATOMESH_TRY(const InputFile file, read_input_file(object.path, options.limits.input));
    const std::string_view bytes(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
    ANATOMESH_TRY(const DataSet set, DataSet::parse(bytes, object.label));
    ANATOMESH_CHECK_STATUS(check_references(set.root(), folder, images, context));
    return are_on_images;
}

// The contours of an RTSTRUCT, held against its images. What small numbers say of the unit holds unless all contours
// lie on images.
Result<RawContours> contours_beside_images(const DicomFolder& folder, const DicomChoice& choice,
                                           const InputOptions& options, RunContext& context) {
    const DicomObject& object = folder.objects[choice.objects[0]];
    const std::size_t said = context.warnings.size();
    Result<RawContours> raw = contours_in(object, options, context);
    std::optional<Error> doubt;
    if (!raw.ok() && raw.error().code == "E-RTS-011") {
        doubt = raw.error();
        context.warnings.resize(said);
        InputOptions as_mm = options;
        as_mm.unit_mm = 1;
        raw = contours_in(object, as_mm, context);
    }
    if (!raw.ok()) return raw;
    ANATOMESH_TRY(const bool are_on_images,
                  compare_with_images(raw.value(), folder, object, choice, options, context));
    if (doubt && !are_on_images) return *doubt;
    return raw;
}

void warn_of_unused_step(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                         const InputOptions& options, RunContext& context) {
    const bool is_used = std::any_of(objects.begin(), objects.end(), [&](std::uint32_t index) {
        return folder.objects[index].placed_by_step;
    });
    if (options.frame_step_mm && !is_used)
        context.warn({"W-CMD-003",
                      "the images state the place of every frame",
                      {options.input, "", "", "", "--frame-step " + number_text(*options.frame_step_mm)},
                      "the option was not used"});
}

}  // namespace

Result<OpenedInput> open_dicom(const InputOptions& options, RunContext& context) {
    ANATOMESH_TRY(const DicomFolder folder,
                  read_dicom_folder(options.input, folder_options(options), context));
    ANATOMESH_TRY(const DicomChoice choice,
                  choose_dicom(folder, options.series, context, choose_options(options)));
    if (options.unit_mm && choice.kind != DicomKind::rtstruct)
        return Error{ErrorKind::usage,
                     "E-CMD-008",
                     "--unit does not apply: the object holds voxels, not contours",
                     {options.input, "", "", "", ""},
                     "leave out --unit"};
    OpenedInput opened;
    const auto& of_study = choice.images.empty() ? choice.objects : choice.images;
    ANATOMESH_TRY(opened.dicom_source,
                  dicom_source(folder, of_study, options.keep_patient_ids, choice.objects));
    const DicomObject& object = folder.objects[choice.objects[0]];
    if (choice.kind == DicomKind::image) {
        ReadSeriesOptions reading;
        if (options.volume) reading.volume = *options.volume;
        reading.allow_gaps = options.allow_gaps;
        if (options.frame == "LPS") reading.frame = ImageFrame::lps;
        if (options.frame == "RAS") reading.frame = ImageFrame::ras;
        warn_of_unused_step(folder, choice.objects, options, context);
        reading.max_voxels = options.limits.voxels;
        reading.limits = options.limits.input;
        opened.kind = FileKind::dicom;
        ANATOMESH_TRY(opened.image, read_dicom_series(folder, choice.objects, reading, context));
        opened.files.push_back(report_of(folder, choice.objects, "DICOM images"));
    } else if (choice.kind == DicomKind::rtstruct) {
        opened.kind = FileKind::dicom_rtstruct;
        ANATOMESH_TRY(opened.contours, contours_beside_images(folder, choice, options, context));
        if (lies_along_images(*opened.contours, folder, choice.images))
            opened.contours->slice_thickness_mm = thickness_of_images(folder, choice.images);
        opened.files.push_back(report_of(folder, choice.objects, name_of(opened.kind)));
    } else {
        opened.kind = FileKind::dicom_segmentation;
        ANATOMESH_TRY(opened.segmentation, segmentation_in(folder, choice, options, context));
        ANATOMESH_TRY(
            [[maybe_unused]] const bool are_on_images,
            compare_with_images(outline_of(*opened.segmentation), folder, object, choice, options, context));
        opened.files.push_back(report_of(folder, choice.objects, name_of(opened.kind)));
    }
    return opened;
}

void warn_of_absent_images(const InputOptions& options, RunContext& context) {
    RunContext apart;  // all else is said as the contours are read
    const auto folder = read_dicom_folder(options.input, folder_options(options), apart);
    if (!folder.ok() || !choose_dicom(folder.value(), "", apart).ok()) return;
    for (Warning& warning : apart.warnings) {
        if (warning.code != "W-DCM-018") continue;
        warning.place.file = options.input;
        context.warn(std::move(warning));
    }
}

namespace {

Result<DicomSource> source_of_input(const InputOptions& options, const std::optional<DicomSource>& source,
                                    RunContext& context) {
    if (source) return *source;
    ANATOMESH_TRY(const FileKind kind, detect(options.input));
    if (kind != FileKind::dicom_rtstruct) return DicomSource{};
    ANATOMESH_TRY(const DicomFolder folder,
                  read_dicom_folder(options.input, folder_options(options), context));
    if (folder.objects.empty()) return DicomSource{};
    return dicom_source(folder, {0}, options.keep_patient_ids);
}

}  // namespace

Result<DicomSource> output_source(const InputOptions& options, const std::optional<DicomSource>& source,
                                  RunContext& context) {
    ANATOMESH_TRY(DicomSource found, source_of_input(options, source, context));
    found.software_version = ANATOMESH_VERSION;
    return found;
}

Result<Json> folder_json(const InputOptions& options, RunContext& context) {
    ANATOMESH_TRY(const DicomFolder folder,
                  read_dicom_folder(options.input, folder_options(options), context));
    if (folder.objects.empty())
        return Error{ErrorKind::input,
                     "E-CMD-012",
                     "the folder holds neither a contour file (.vtp) nor a DICOM object",
                     {options.input, "", "", "", ""},
                     "give a file, or a folder of DICOM objects"};
    Json json;
    json["files"] = folder.files;
    json["skipped"] = folder.skipped;
    json["damaged"] = folder.damaged.size();
    json["series"] = Json::array();
    constexpr const char* kinds[] = {"images", "RTSTRUCT", "SEG", "other"};
    for (const DicomSeries& series : folder.series) {
        const DicomObject& first = folder.objects[series.objects[0]];
        Json each;
        each["series"] = series.name;
        each["study"] = options.keep_patient_ids ? series.study : series_name(series.study);
        each["kind"] = kinds[static_cast<int>(series.kind)];
        each["what"] = describe_series(folder, series).substr(series.name.size() + 2);
        each["objects"] = series.objects.size();
        if (options.keep_patient_ids) each["description"] = first.description;
        each["refers_to"] = Json::array();
        for (const std::string& uid : first.referenced_series)
            each["refers_to"].push_back(options.keep_patient_ids ? uid : series_name(uid));
        std::size_t damaged = 0;
        for (const std::uint32_t index : series.objects) damaged += folder.objects[index].damage.has_value();
        each["damaged"] = damaged;
        json["series"].push_back(std::move(each));
    }
    return json;
}

std::string folder_text(const Json& folder) {
    std::string text = fmt::format(
        "  {}, {} of them no DICOM, {} damaged\n", counted(folder["files"].get<std::uint64_t>(), "file"),
        folder["skipped"].get<std::uint64_t>(), folder["damaged"].get<std::uint64_t>());
    for (const Json& series : folder["series"]) {
        text += fmt::format("  series {}  {}", series["series"].get<std::string>(),
                            series["what"].get<std::string>());
        for (const Json& other : series["refers_to"])
            text += fmt::format(", refers to {}", other.get<std::string>());
        if (series["damaged"].get<std::size_t>() > 0)
            text += fmt::format(", {} damaged", series["damaged"].get<std::size_t>());
        text += "\n";
    }
    return text;
}

}  // namespace anatomesh
