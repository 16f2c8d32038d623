#include "anatomesh_io/dicom/object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/dicom/frame_groups.h"
#include "anatomesh_io/dicom/frame_places.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// A file that announces more frames is refused, before they take all memory. [frames; >= 1; B]
constexpr std::uint64_t max_frames = 1'000'000;

// Scales of the regions of an ultrasound image that show tissue in two dimensions and state a unit of length:
// mm between columns, between rows.
struct UltrasoundScales {
    std::size_t regions = 0;  // of any kind
    std::vector<std::array<double, 2>> scales;
    std::vector<std::size_t> region;  // which one each is of, from 0
};

Result<UltrasoundScales> ultrasound_scales(const DicomItem& root) {
    // This Region Spatial Format is a two-dimensional image. [code; 1; D DICOM PS3.3, section C.8.5.5]
    constexpr std::uint32_t two_dimensional = 1;
    // This Physical Unit is the centimetre. [code; 3; D DICOM PS3.3, section C.8.5.5]
    constexpr std::uint32_t centimetres = 3;
    UltrasoundScales found;
    for (const DicomItem& region : root.items(tags::ultrasound_regions)) {
        const std::size_t index = found.regions++;
        ANATOMESH_TRY(const auto format, unsigned_short(region, tags::region_spatial_format));
        ANATOMESH_TRY(const auto unit_x, unsigned_short(region, tags::region_units_x));
        ANATOMESH_TRY(const auto unit_y, unsigned_short(region, tags::region_units_y));
        ANATOMESH_TRY(const auto x, float_double(region, tags::region_delta_x));
        ANATOMESH_TRY(const auto y, float_double(region, tags::region_delta_y));
        if (format != two_dimensional || unit_x != centimetres || unit_y != centimetres || !x || !y) continue;
        // Towards the top or the left it may be negative.
        found.scales.push_back({std::abs(*x) * 10, std::abs(*y) * 10});
        found.region.push_back(index);
    }
    return found;
}

bool same_scale(const std::array<double, 2>& a, const std::array<double, 2>& b) {
    return std::abs(a[0] - b[0]) <= 1e-3 * std::abs(b[0]) && std::abs(a[1] - b[1]) <= 1e-3 * std::abs(b[1]);
}

// The scale of an ultrasound image by its regions, as PixelSpacing has it (rows first); nothing when it has
// no regions.
Result<std::optional<std::vector<double>>> spacing_of_regions(const DataSet& set,
                                                              std::optional<std::uint32_t> chosen) {
    ANATOMESH_TRY(const UltrasoundScales found, ultrasound_scales(set.root()));
    if (found.regions == 0) return std::optional<std::vector<double>>{};
    std::string list;
    bool is_one = true;
    for (std::size_t i = 0; i < found.scales.size(); ++i) {
        const auto& scale = found.scales[i];
        if (chosen == found.region[i]) return std::optional(std::vector{scale[1], scale[0]});
        is_one = is_one && same_scale(scale, found.scales[0]);
        list += fmt::format("{}{}: {:.6g} x {:.6g} mm", i ? ", " : "", found.region[i], scale[0], scale[1]);
    }
    if (chosen)
        return frame_error(
            "E-DCM-034", set, 0, 1, "the image has no calibrated ultrasound region of this number",
            std::to_string(*chosen), list.empty() ? "give a calibrated image" : "choose one of " + list);
    if (found.scales.empty())
        return frame_error(
            "E-DCM-006", set, 0, 1,
            "PixelSpacing is missing, and no ultrasound region of two dimensions has a unit of length",
            fmt::format("{} regions", found.regions), "give a calibrated series");
    if (!is_one)
        return frame_error("E-DCM-034", set, 0, 1, "the ultrasound regions have different scales", list,
                           "choose one with --ultrasound-region N");
    return std::optional(std::vector{found.scales[0][1], found.scales[0][0]});
}

// A region may not contradict the PixelSpacing that counts.
Status compare_with_regions(const DataSet& set, const std::vector<DicomFrame>& frames, RunContext& context) {
    const auto found = ultrasound_scales(set.root());
    if (!found.ok() || found.value().scales.empty()) return Nothing{};
    for (const auto& scale : found.value().scales)
        if (same_scale(scale, frames[0].spacing)) return Nothing{};
    const auto& scale = found.value().scales[0];
    context.warn({"W-DCM-021",
                  "the scale of the ultrasound region differs from PixelSpacing",
                  {set.name(), {}, {}, {}, fmt::format("{:.6g} x {:.6g} mm", scale[0], scale[1])},
                  fmt::format("PixelSpacing was used: {:.6g} x {:.6g} mm", frames[0].spacing[0],
                              frames[0].spacing[1])});
    return Nothing{};
}

Status read_spacing(const DataSet& set, const FrameGroups& groups, std::uint32_t frames,
                    std::optional<std::uint32_t> ultrasound_region, DicomFrame& frame) {
    const DicomItem holder = groups.holder(tags::pixel_measures_sequence, tags::pixel_spacing);
    ANATOMESH_TRY(auto spacing, decimals(holder, tags::pixel_spacing, 2));
    if (!spacing) {
        ANATOMESH_TRY(spacing, spacing_of_regions(set, ultrasound_region));
    }
    if (!spacing)
        return frame_error(
            "E-DCM-006", set, frame.frame, frames,
            set.root().find(tags::imager_pixel_spacing)
                ? "PixelSpacing is missing; ImagerPixelSpacing applies to the detector, not to the patient"
                : "PixelSpacing is missing",
            {}, "give a calibrated series");
    for (const double each : *spacing)
        if (!(each >= 1e-6 && each <= 1e4))
            return frame_error("E-DCM-006", set, frame.frame, frames, "PixelSpacing is not a possible size",
                               vector_text(*spacing), "correct the file, or export it again");
    // The first value is the distance of rows, the second that of columns.
    frame.spacing = {(*spacing)[1], (*spacing)[0]};
    return Nothing{};
}

Status read_rescale(const FrameGroups& groups, DicomFrame& frame) {
    const DicomItem slope = groups.holder(tags::pixel_transformation_sequence, tags::rescale_slope);
    const DicomItem intercept = groups.holder(tags::pixel_transformation_sequence, tags::rescale_intercept);
    ANATOMESH_TRY(const auto a, decimal(slope, tags::rescale_slope));
    ANATOMESH_TRY(const auto b, decimal(intercept, tags::rescale_intercept));
    if (a && *a == 0) return bad_value(slope, tags::rescale_slope, "is 0: all values would be equal");
    frame.slope = a.value_or(1);
    frame.intercept = b.value_or(0);
    return Nothing{};
}

void read_marks(const DicomItem& root, const FrameGroups& groups, DicomFrame& frame) {
    const auto text = [&](DicomTag group, DicomTag tag) {
        const DicomItem holder = groups.holder(group, tag);
        return std::string(shown(holder.text(tag)));
    };
    frame.mark[0] = shown(root.text(tags::acquisition_number));
    frame.mark[1] = shown(root.text(tags::temporal_position));
    // Indices in frame content are unsigned longs.
    const DicomItem content = groups.holder(tags::frame_content_sequence, tags::temporal_position_index);
    if (const std::string_view index = content.bytes(tags::temporal_position_index); index.size() == 4) {
        std::uint32_t value = 0;
        for (int i = 3; i >= 0; --i)
            value = value << 8 | static_cast<unsigned char>(index[static_cast<std::size_t>(i)]);
        frame.mark[1] = std::to_string(value);
    }
    frame.mark[2] = text(tags::frame_content_sequence, tags::trigger_time);
    frame.mark[3] = shown(root.text(root.find(tags::echo_number) ? tags::echo_number : tags::echo_time));
    frame.mark[4] = shown(root.text(tags::b_value));
}

Result<std::uint32_t> frame_count(const DicomItem& root) {
    ANATOMESH_TRY(const auto stated, whole_number(root, tags::number_of_frames));
    if (!stated) return std::uint32_t{1};
    if (*stated < 1 || static_cast<std::uint64_t>(*stated) > max_frames) {
        Error error = bad_value(root, tags::number_of_frames, "is not a possible number of frames");
        error.code = "E-DCM-007";
        return error;
    }
    return static_cast<std::uint32_t>(*stated);
}

// Frames without functional groups may follow the first; each has a byte of pixels at least, so that a number alone
// cannot take memory.
Status check_frames_without_groups(const DataSet& set, std::uint32_t count, std::size_t groups) {
    const DicomItem root = set.root();
    std::size_t bytes = root.bytes(tags::pixel_data).size();
    for (const std::string_view fragment : root.fragments(tags::pixel_data)) bytes += fragment.size();
    if (groups == 0 && states_first_place(root) && bytes >= count) return Nothing{};
    return frame_error("E-DCM-007", set, 0, 1,
                       fmt::format("the file has {} frames, but positions for {}", count, groups), {},
                       "give a series of single images, or an enhanced multi-frame object");
}

void add_references(const DicomItem& root, DicomObject& object) {
    const auto add_instances = [&](const DicomItem& item, DicomTag sequence) {
        for (const DicomItem& image : item.items(sequence))
            object.referenced_instances.emplace_back(image.text(tags::referenced_sop_instance));
    };
    const auto add_series = [&](const DicomItem& item, DicomTag sequence) {
        object.referenced_series.emplace_back(item.text(tags::series_instance));
        add_instances(item, sequence);
    };
    for (const DicomItem& frame : root.items(tags::referenced_frame_sequence)) {
        if (object.frame_of_reference.empty())
            object.frame_of_reference = frame.text(tags::frame_of_reference);
        for (const DicomItem& study : frame.items(tags::rt_referenced_study_sequence))
            for (const DicomItem& series : study.items(tags::rt_referenced_series_sequence))
                add_series(series, tags::contour_image_sequence);
    }
    for (const DicomItem& series : root.items(tags::referenced_series_sequence))
        add_series(series, tags::referenced_instance_sequence);
    std::erase(object.referenced_series, "");
    std::erase(object.referenced_instances, "");
    for (auto* list : {&object.referenced_series, &object.referenced_instances}) {
        std::sort(list->begin(), list->end());
        list->erase(std::unique(list->begin(), list->end()), list->end());
    }
}

DicomKind kind_of(const DicomObject& object, const DicomItem& root) {
    if (object.sop_class == "1.2.840.10008.5.1.4.1.1.481.3") return DicomKind::rtstruct;
    if (object.sop_class == "1.2.840.10008.5.1.4.1.1.66.4" ||
        object.sop_class == "1.2.840.10008.5.1.4.1.1.66.7")
        return DicomKind::segmentation;
    if (object.sop_class.empty() && object.modality == "RTSTRUCT") return DicomKind::rtstruct;
    return root.find(tags::pixel_data) && object.modality != "RTDOSE" ? DicomKind::image : DicomKind::other;
}

// What one frame alone and checks of many need; an enhanced object says it in its functional groups.
void describe_slices(const DicomItem& root, DicomObject& object) {
    const std::vector<DicomItem> per_frame = root.items(tags::per_frame_groups);
    const FrameGroups groups(root, root.item(tags::shared_groups),
                             per_frame.empty() ? std::nullopt : std::optional(per_frame[0]));
    const auto number = [&](DicomTag tag) -> std::optional<double> {
        const auto value = decimal(groups.holder(tags::pixel_measures_sequence, tag), tag);
        return value.ok() ? value.value() : std::nullopt;
    };
    object.spacing_between_slices = number(tags::spacing_between_slices);
    // Of nuclear medicine the sign is a direction.
    const bool is_signed = object.sop_class == "1.2.840.10008.5.1.4.1.1.20" && object.spacing_between_slices;
    if (is_signed) object.spacing_between_slices = std::abs(*object.spacing_between_slices);
    object.slice_thickness = number(tags::slice_thickness);
}

void describe_image(const DataSet& set, const FrameOptions& options, DicomObject& object) {
    RunContext context;
    auto format = read_pixel_format(set, context);
    auto planes = format.ok() ? read_frames(set, context, options) : Result<FramesOfObject>(format.error());
    object.image_warnings = std::move(context.warnings);
    if (!planes.ok()) {
        object.image_error = planes.error();
        return;
    }
    object.format = format.value();
    object.planes = std::move(planes.value().frames);
    object.known_axes = planes.value().known_axes;
    object.placed_by_step = planes.value().by_step;
    // Coordinates of a volume alone are not those of the patient, whatever the patient's are called.
    if (!object.known_axes) object.frame_of_reference = set.root().text(tags::volume_frame_of_reference);
}

}  // namespace

const char* mark_name(std::size_t mark) {
    constexpr std::array names{"AcquisitionNumber", "temporal position", "TriggerTime", "echo", "b-value"};
    return names[mark];
}

DicomObject describe_object(const DataSet& set, const std::string& path, const std::string& label,
                            const FrameOptions& options) {
    const DicomItem root = set.root();
    DicomObject object;
    object.path = path;
    object.label = label;
    object.transfer_syntax = set.layout().transfer_syntax;
    object.sop_class = root.text(tags::sop_class);
    object.sop_instance = root.text(tags::sop_instance);
    object.study = root.text(tags::study_instance);
    object.series = root.text(tags::series_instance);
    object.frame_of_reference = root.text(tags::frame_of_reference);
    object.modality = root.text(tags::modality);
    object.image_type = root.text(tags::image_type);
    object.description = dicom_text(root.text(tags::series_description), root.text(tags::character_set)).text;
    object.patient_key =
        sha256_text(fmt::format("{}\n{}", root.text(tags::patient_name), root.text(tags::patient_id)));
    const auto number = [&](DicomTag tag) -> std::optional<double> {
        const auto value = decimal(root, tag);
        return value.ok() ? value.value() : std::nullopt;
    };
    const auto count = [&](DicomTag tag) {
        const auto value = unsigned_short(root, tag);
        return value.ok() ? value.value().value_or(0) : 0;
    };
    if (const auto value = whole_number(root, tags::series_number); value.ok())
        object.series_number = value.value().value_or(0);
    object.rows = count(tags::rows);
    object.columns = count(tags::columns);
    if (const auto frames = frame_count(root); frames.ok()) object.frames = frames.value();
    object.gantry_tilt = number(tags::gantry_tilt);
    object.images_in_acquisition = number(tags::images_in_acquisition);
    describe_slices(root, object);
    object.kind = kind_of(object, root);
    add_references(root, object);
    if (object.kind == DicomKind::image || object.kind == DicomKind::segmentation)
        describe_image(set, options, object);
    return object;
}

Result<FramesOfObject> read_frames(const DataSet& set, RunContext& context, const FrameOptions& options) {
    const DicomItem root = set.root();
    ANATOMESH_TRY(const std::uint32_t count, frame_count(root));
    const std::vector<DicomItem> per_frame = root.items(tags::per_frame_groups);
    if (count > 1 && per_frame.size() != count) {
        ANATOMESH_CHECK_STATUS(check_frames_without_groups(set, count, per_frame.size()));
    }
    ANATOMESH_TRY(const auto rows, unsigned_short(root, tags::rows));
    ANATOMESH_TRY(const auto columns, unsigned_short(root, tags::columns));
    ANATOMESH_TRY(const auto number, whole_number(root, tags::instance_number));
    const auto shared = root.item(tags::shared_groups);
    std::vector<FrameGroups> groups;
    groups.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i)
        groups.emplace_back(root, shared, i < per_frame.size() ? std::optional(per_frame[i]) : std::nullopt);
    FramesOfObject found;
    found.frames.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        DicomFrame& frame = found.frames[i];
        frame.frame = i;
        frame.rows = rows.value_or(0);
        frame.columns = columns.value_or(0);
        frame.number = count == 1 ? number.value_or(0) : 0;
    }
    double worst_orientation = 0;
    ANATOMESH_CHECK_STATUS(place_frames(set, groups, options.step_mm, found, worst_orientation));
    for (std::uint32_t i = 0; i < count; ++i) {
        DicomFrame& frame = found.frames[i];
        ANATOMESH_CHECK_STATUS(read_spacing(set, groups[i], count, options.ultrasound_region, frame));
        ANATOMESH_CHECK_STATUS(read_rescale(groups[i], frame));
        read_marks(root, groups[i], frame);
    }
    if (worst_orientation > 1e-4)
        context.warn({"W-DCM-005",
                      "ImageOrientationPatient is not exactly two unit vectors at right angles",
                      {set.name(), {}, {}, {}, fmt::format("off by {:.2g}", worst_orientation)},
                      "the vectors were corrected"});
    ANATOMESH_CHECK_STATUS(compare_with_regions(set, found.frames, context));
    return found;
}

Result<PixelFormat> read_pixel_format(const DataSet& set, RunContext& context) {
    const DicomItem root = set.root();
    const auto required = [&](DicomTag tag, std::uint32_t& value) -> Status {
        ANATOMESH_TRY(const auto found, unsigned_short(root, tag));
        if (!found) return missing_value(root, tag, "is missing");
        value = *found;
        return Nothing{};
    };
    const auto impossible = [&](DicomTag tag, const std::string& what, std::string value) {
        Error error = bad_value(root, tag, what);
        error.code = "E-DCM-010";
        error.place.value = std::move(value);
        return error;
    };
    PixelFormat format;
    std::uint32_t samples = 1, representation = 0;
    ANATOMESH_CHECK_STATUS(required(tags::rows, format.rows));
    ANATOMESH_CHECK_STATUS(required(tags::columns, format.columns));
    ANATOMESH_CHECK_STATUS(required(tags::bits_allocated, format.bits_allocated));
    ANATOMESH_TRY(const auto stored, unsigned_short(root, tags::bits_stored));
    ANATOMESH_TRY(const auto high, unsigned_short(root, tags::high_bit));
    ANATOMESH_TRY(const auto signs, unsigned_short(root, tags::pixel_representation));
    ANATOMESH_TRY(const auto sample_count, unsigned_short(root, tags::samples_per_pixel));
    ANATOMESH_TRY(format.frames, frame_count(root));
    format.bits_stored = stored.value_or(format.bits_allocated);
    format.high_bit = high.value_or(format.bits_stored - 1);
    representation = signs.value_or(0);
    samples = sample_count.value_or(1);
    if (format.rows == 0 || format.columns == 0)
        return impossible(tags::rows, "or Columns is 0", fmt::format("{} x {}", format.columns, format.rows));
    const std::string_view photometric = root.text(tags::photometric);
    if (samples != 1 || (!photometric.empty() && !photometric.starts_with("MONOCHROME")))
        return impossible(tags::photometric, "is not grey (MONOCHROME1 or MONOCHROME2)",
                          shown(photometric) + fmt::format(", {} samples", samples));
    const auto bits = format.bits_allocated;
    if ((bits != 1 && bits != 8 && bits != 16 && bits != 32) || representation > 1)
        return impossible(tags::bits_allocated, "is a pixel type that is not read",
                          fmt::format("{} bits, representation {}", bits, representation));
    if (format.bits_stored == 0 || format.bits_stored > bits)
        return impossible(tags::bits_stored, "does not fit BitsAllocated",
                          fmt::format("{} of {} bits", format.bits_stored, bits));
    format.is_signed = representation == 1;
    if (format.high_bit + 1 != format.bits_stored) {
        const bool usable = format.high_bit < bits && format.high_bit + 1 >= format.bits_stored;
        context.warn({"W-DCM-006",
                      "HighBit differs from BitsStored - 1",
                      {set.name(), {}, {}, {}, std::to_string(format.high_bit)},
                      usable ? "the bits below HighBit were read" : "the lowest bits were read"});
        if (!usable) format.high_bit = format.bits_stored - 1;
    }
    if (photometric == "MONOCHROME1")
        context.warn({"W-DCM-007",
                      "the image shows low values bright (MONOCHROME1)",
                      {set.name(), {}, {}, {}, {}},
                      "the stored values were used"});
    return format;
}

}  // namespace anatomesh
