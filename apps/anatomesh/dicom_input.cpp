#include "dicom_input.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "anatomesh_io/contour/read_contours.h"
#include "anatomesh_io/dicom/choose.h"
#include "anatomesh_io/dicom/read_series.h"
#include "anatomesh_io/dicom/segmentation.h"
#include "plural.h"

namespace anatomesh {

namespace {

using Json = nlohmann::ordered_json;

DicomFolderOptions folder_options(const InputOptions& options) {
    DicomFolderOptions reading;
    reading.keep_names = options.keep_patient_ids;
    reading.limits = options.limits.input;
    return reading;
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

Result<LoadedSegmentation> segmentation_in(const DicomObject& object, const InputOptions& options,
                                           RunContext& context) {
    ANATOMESH_TRY(const InputFile file, read_input_file(object.path, options.limits.input));
    const std::string_view bytes(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
    ReadSegmentationOptions reading;
    reading.max_voxels = options.limits.voxels;
    return read_dicom_segmentation(bytes, object.label, reading, context);
}

}  // namespace

Result<OpenedInput> open_dicom(const InputOptions& options, RunContext& context) {
    ANATOMESH_TRY(const DicomFolder folder,
                  read_dicom_folder(options.input, folder_options(options), context));
    ANATOMESH_TRY(const DicomChoice choice, choose_dicom(folder, options.series, context));
    OpenedInput opened;
    const auto& of_study = choice.images.empty() ? choice.objects : choice.images;
    ANATOMESH_TRY(opened.dicom_source, dicom_source(folder, of_study, options.keep_patient_ids));
    const DicomObject& object = folder.objects[choice.objects[0]];
    if (choice.kind == DicomKind::image) {
        ReadSeriesOptions reading;
        if (options.volume) reading.volume = *options.volume;
        reading.allow_gaps = options.allow_gaps;
        reading.max_voxels = options.limits.voxels;
        reading.limits = options.limits.input;
        opened.kind = FileKind::dicom;
        ANATOMESH_TRY(opened.image, read_dicom_series(folder, choice.objects, reading, context));
        opened.files.push_back(report_of(folder, choice.objects, "DICOM images"));
    } else if (choice.kind == DicomKind::rtstruct) {
        opened.kind = FileKind::dicom_rtstruct;
        ANATOMESH_TRY(opened.contours, contours_in(object, options, context));
        check_against_images(*opened.contours, folder, choice.images, context);
        opened.files.push_back(report_of(folder, choice.objects, name_of(opened.kind)));
    } else {
        opened.kind = FileKind::dicom_segmentation;
        ANATOMESH_TRY(opened.segmentation, segmentation_in(object, options, context));
        opened.files.push_back(report_of(folder, choice.objects, name_of(opened.kind)));
    }
    return opened;
}

Result<DicomSource> output_source(const InputOptions& options, const std::optional<DicomSource>& source,
                                  RunContext& context) {
    if (source) return *source;
    ANATOMESH_TRY(const FileKind kind, detect(options.input));
    if (kind != FileKind::dicom_rtstruct) return DicomSource{};
    ANATOMESH_TRY(const DicomFolder folder,
                  read_dicom_folder(options.input, folder_options(options), context));
    if (folder.objects.empty()) return DicomSource{};
    return dicom_source(folder, {0}, options.keep_patient_ids);
}

Result<Json> folder_json(const InputOptions& options, RunContext& context) {
    ANATOMESH_TRY(const DicomFolder folder,
                  read_dicom_folder(options.input, folder_options(options), context));
    if (folder.objects.empty())
        return Error{ErrorKind::input,
                     "E-CMD-012",
                     "this is a folder, and neither a contour file (.vtp) nor a DICOM object is in it",
                     {options.input, "", "", "", ""},
                     "name a file in it, or a folder of DICOM objects"};
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
