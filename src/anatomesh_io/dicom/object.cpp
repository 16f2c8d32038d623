#include "anatomesh_io/dicom/object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/geom/numbers.h"
#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// A file that announces more frames is refused, before they take all memory. [frames; >= 1; B]
constexpr std::uint64_t max_frames = 1'000'000;

// The functional groups of a frame: its own, those that all frames share, and the object itself.
class FrameGroups {
  public:
    FrameGroups(const DicomItem& root, std::optional<DicomItem> shared, std::optional<DicomItem> own)
        : root_(root), shared_(std::move(shared)), own_(std::move(own)) {}

    // The item that holds the element: in the sequence `group` of the frame, of the shared ones, or in the
    // object.
    const DicomItem holder(DicomTag group, DicomTag tag) const {
        for (const auto* groups : {&own_, &shared_}) {
            if (!*groups) continue;
            const auto item = (*groups)->item(group);
            if (item && item->find(tag)) return *item;
        }
        return root_;
    }
    const std::optional<DicomItem>& shared() const { return shared_; }
    const std::optional<DicomItem>& own() const { return own_; }

  private:
    DicomItem root_;
    std::optional<DicomItem> shared_, own_;
};

Error frame_error(const char* code, const DataSet& set, std::uint32_t frame, std::uint32_t frames,
                  const std::string& message, std::string value, const std::string& next_step) {
    return {ErrorKind::input,
            code,
            message,
            {set.name(), frames > 1 ? fmt::format("frame {}", frame + 1) : "", {}, {}, std::move(value)},
            next_step};
}

std::string vector_text(const std::vector<double>& values) {
    std::string text;
    for (const double value : values) {
        if (!text.empty()) text += ' ';
        append_number(text, value);
    }
    return text;
}

// A direction within rounding of a unit vector orthogonal to `other`, made exactly so (Gram-Schmidt).
struct Orientation {
    Vec3 row, column;
    double error = 0;  // how far from orthonormal
};
Orientation orthonormal(const std::vector<double>& v) {
    const Vec3 row{v[0], v[1], v[2]}, column{v[3], v[4], v[5]};
    Orientation found;
    found.error =
        std::max({std::abs(length(row) - 1), std::abs(length(column) - 1), std::abs(dot(row, column))});
    if (!(found.error < 0.01)) return found;
    // Directions of the axes stay as they are, to the last bit.
    found.row = row == Vec3{1, 0, 0} ? row : normalized(row);
    const Vec3 rest = column - dot(found.row, column) * found.row;
    found.column = length(rest) == 1 ? rest : normalized(rest);
    return found;
}

Status read_place(const DataSet& set, const FrameGroups& groups, std::uint32_t frames, DicomFrame& frame,
                  double& worst_orientation) {
    const DicomItem at = groups.holder(tags::plane_position_sequence, tags::image_position);
    const DicomItem along = groups.holder(tags::plane_orientation_sequence, tags::image_orientation);
    ANATOMESH_TRY(const auto position, decimals(at, tags::image_position, 3));
    ANATOMESH_TRY(const auto orientation, decimals(along, tags::image_orientation, 6));
    if (!position || !orientation)
        return frame_error(
            "E-DCM-004", set, frame.frame, frames,
            fmt::format("{} is missing, so that the position of the image is unknown",
                        position ? "ImageOrientationPatient" : "ImagePositionPatient"),
            {}, "give a series with positions, or convert it to NIfTI or NRRD with known positions");
    const Orientation axes = orthonormal(*orientation);
    if (!(axes.error < 0.01))
        return frame_error("E-DCM-005", set, frame.frame, frames,
                           "ImageOrientationPatient is not two unit vectors at right angles",
                           vector_text(*orientation), "correct the file, or export it again");
    worst_orientation = std::max(worst_orientation, axes.error);
    frame.row = axes.row;
    frame.column = axes.column;
    for (double each : *position)
        if (!(std::abs(each) <= coordinate_bound_mm))
            return frame_error("E-DCM-008", set, frame.frame, frames,
                               "the position of the image is beyond 1e7 mm", vector_text(*position),
                               "correct the file, or export it again");
    const auto clean = [](double x) { return std::abs(x) < 1e-300 ? 0.0 : x; };
    frame.position = {clean((*position)[0]), clean((*position)[1]), clean((*position)[2])};
    return Nothing{};
}

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

// Both the frames and what they share may say the orientation, but not differently.
Status check_shared_orientation(const DataSet& set, const FrameGroups& groups, std::uint32_t frame) {
    const auto orientation = [](const std::optional<DicomItem>& of) -> std::string {
        const auto item = of ? of->item(tags::plane_orientation_sequence) : std::nullopt;
        return item ? std::string(item->text(tags::image_orientation)) : std::string{};
    };
    const std::string own = orientation(groups.own()), shared = orientation(groups.shared());
    if (own.empty() || shared.empty() || own == shared) return Nothing{};
    return frame_error("E-DCM-009", set, frame, 2,
                       "the orientation of the frame contradicts the orientation that all frames share",
                       shown(own), "correct the file, or export it again");
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

void describe_image(const DataSet& set, std::optional<std::uint32_t> ultrasound_region, DicomObject& object) {
    RunContext context;
    auto format = read_pixel_format(set, context);
    auto planes = format.ok() ? read_frames(set, context, ultrasound_region)
                              : Result<std::vector<DicomFrame>>(format.error());
    object.image_warnings = std::move(context.warnings);
    if (!planes.ok()) {
        object.image_error = planes.error();
        return;
    }
    object.format = format.value();
    object.planes = std::move(planes).value();
}

}  // namespace

const char* mark_name(std::size_t mark) {
    constexpr std::array names{"AcquisitionNumber", "temporal position", "TriggerTime", "echo", "b-value"};
    return names[mark];
}

DicomObject describe_object(const DataSet& set, const std::string& path, const std::string& label,
                            std::optional<std::uint32_t> ultrasound_region) {
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
    object.spacing_between_slices = number(tags::spacing_between_slices);
    object.images_in_acquisition = number(tags::images_in_acquisition);
    object.slice_thickness = number(tags::slice_thickness);
    object.kind = kind_of(object, root);
    add_references(root, object);
    if (object.kind == DicomKind::image || object.kind == DicomKind::segmentation)
        describe_image(set, ultrasound_region, object);
    return object;
}

Result<std::vector<DicomFrame>> read_frames(const DataSet& set, RunContext& context,
                                            std::optional<std::uint32_t> ultrasound_region) {
    const DicomItem root = set.root();
    ANATOMESH_TRY(const std::uint32_t count, frame_count(root));
    const std::vector<DicomItem> per_frame = root.items(tags::per_frame_groups);
    if (count > 1 && per_frame.size() != count)
        return frame_error(
            "E-DCM-007", set, 0, 1,
            fmt::format("the file has {} frames, but positions for {}", count, per_frame.size()), {},
            "give a series of single images, or an enhanced multi-frame object");
    ANATOMESH_TRY(const auto rows, unsigned_short(root, tags::rows));
    ANATOMESH_TRY(const auto columns, unsigned_short(root, tags::columns));
    ANATOMESH_TRY(const auto number, whole_number(root, tags::instance_number));
    const auto shared = root.item(tags::shared_groups);
    double worst_orientation = 0;
    std::vector<DicomFrame> frames(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const FrameGroups groups(root, shared,
                                 i < per_frame.size() ? std::optional(per_frame[i]) : std::nullopt);
        DicomFrame& frame = frames[i];
        frame.frame = i;
        frame.rows = rows.value_or(0);
        frame.columns = columns.value_or(0);
        frame.number = count == 1 ? number.value_or(0) : 0;
        ANATOMESH_CHECK_STATUS(check_shared_orientation(set, groups, i));
        ANATOMESH_CHECK_STATUS(read_place(set, groups, count, frame, worst_orientation));
        ANATOMESH_CHECK_STATUS(read_spacing(set, groups, count, ultrasound_region, frame));
        ANATOMESH_CHECK_STATUS(read_rescale(groups, frame));
        read_marks(root, groups, frame);
    }
    if (worst_orientation > 1e-4)
        context.warn({"W-DCM-005",
                      "ImageOrientationPatient is not exactly two unit vectors at right angles",
                      {set.name(), {}, {}, {}, fmt::format("off by {:.2g}", worst_orientation)},
                      "the vectors were corrected"});
    ANATOMESH_CHECK_STATUS(compare_with_regions(set, frames, context));
    return frames;
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
