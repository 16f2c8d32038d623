#include "anatomesh_io/dicom/frame_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "anatomesh/geom/numbers.h"
#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

// The elements that hold the places of frames, and how many bytes a number in them has: 0 is a text.
struct PlaceTags {
    DicomTag position_group, position, orientation_group, orientation;
    bool is_text = true;
    const char *position_name = "", *orientation_name = "";
};
constexpr PlaceTags of_patient{tags::plane_position_sequence,
                               tags::image_position,
                               tags::plane_orientation_sequence,
                               tags::image_orientation,
                               true,
                               "ImagePositionPatient",
                               "ImageOrientationPatient"};
constexpr PlaceTags of_volume{tags::plane_position_volume_sequence,
                              tags::image_position_volume,
                              tags::plane_orientation_volume_sequence,
                              tags::image_orientation_volume,
                              false,
                              "ImagePositionVolume",
                              "ImageOrientationVolume"};

constexpr const char* correct_the_file = "correct the file, or export it again";

Result<std::optional<std::vector<double>>> numbers_of(const DicomItem& item, DicomTag tag, std::size_t count,
                                                      bool is_text) {
    return is_text ? decimals(item, tag, count) : float_doubles(item, tag, count);
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

bool is_in_bounds(Vec3 p) {
    return std::abs(p.x) <= coordinate_bound_mm && std::abs(p.y) <= coordinate_bound_mm &&
           std::abs(p.z) <= coordinate_bound_mm;
}

// The place that two items say, of the frame that errors name.
class PlaceReader {
  public:
    PlaceReader(const DataSet& set, const PlaceTags& tags, std::uint32_t frames, double& worst_orientation)
        : set_(set), tags_(tags), frames_(frames), worst_(worst_orientation) {}

    Error missing(std::uint32_t frame, const char* name) const {
        return frame_error(
            "E-DCM-004", set_, frame, frames_,
            fmt::format("{} is missing, so that the position of the image is unknown", name), {},
            "give a series with positions, or convert it to NIfTI or NRRD with known positions");
    }

    Error beyond(std::uint32_t frame, const std::vector<double>& position) const {
        return frame_error("E-DCM-008", set_, frame, frames_, "the position of the image is beyond 1e7 mm",
                           vector_text(position), correct_the_file);
    }

    Status read(const std::optional<DicomItem>& at, const std::optional<DicomItem>& along,
                DicomFrame& frame) {
        std::optional<std::vector<double>> position, orientation;
        if (at) {
            ANATOMESH_TRY(position, numbers_of(*at, tags_.position, 3, tags_.is_text));
        }
        if (along) {
            ANATOMESH_TRY(orientation, numbers_of(*along, tags_.orientation, 6, tags_.is_text));
        }
        if (!position) return missing(frame.frame, tags_.position_name);
        if (!orientation) return missing(frame.frame, tags_.orientation_name);
        const Orientation axes = orthonormal(*orientation);
        if (!(axes.error < 0.01))
            return frame_error(
                "E-DCM-005", set_, frame.frame, frames_,
                fmt::format("{} is not two unit vectors at right angles", tags_.orientation_name),
                vector_text(*orientation), correct_the_file);
        worst_ = std::max(worst_, axes.error);
        frame.row = axes.row;
        frame.column = axes.column;
        if (!is_in_bounds({(*position)[0], (*position)[1], (*position)[2]}))
            return beyond(frame.frame, *position);
        const auto clean = [](double x) { return std::abs(x) < 1e-300 ? 0.0 : x; };
        frame.position = {clean((*position)[0]), clean((*position)[1]), clean((*position)[2])};
        return Nothing{};
    }

  private:
    const DataSet& set_;
    const PlaceTags& tags_;
    std::uint32_t frames_;
    double& worst_;
};

bool groups_state_position(const std::vector<FrameGroups>& groups, const PlaceTags& tags) {
    return std::any_of(groups.begin(), groups.end(), [&](const FrameGroups& each) {
        return each.own(tags.position_group, tags.position) ||
               each.shared(tags.position_group, tags.position);
    });
}

// Both the frames and what they share may say the orientation, but not differently.
Status check_shared_orientation(const DataSet& set, const FrameGroups& groups, const PlaceTags& tags,
                                std::uint32_t frame) {
    const auto own = groups.own(tags.orientation_group, tags.orientation);
    const auto shared = groups.shared(tags.orientation_group, tags.orientation);
    if (!own || !shared) return Nothing{};
    const auto a = own->text(tags.orientation), b = shared->text(tags.orientation);
    if (a.empty() || b.empty() || a == b) return Nothing{};
    ANATOMESH_TRY(const auto values, numbers_of(*own, tags.orientation, 6, tags.is_text));
    return frame_error("E-DCM-009", set, frame, 2,
                       "the orientation of the frame contradicts the orientation that all frames share",
                       values ? vector_text(*values) : "", correct_the_file);
}

// Where one frame says its own position all do: what they share would put the others at one place.
Status place_by_groups(const DataSet& set, const std::vector<FrameGroups>& groups, const PlaceTags& tags,
                       FramesOfObject& found, double& worst_orientation) {
    const bool each_its_own = std::any_of(groups.begin(), groups.end(), [&](const FrameGroups& each) {
        return each.own(tags.position_group, tags.position).has_value();
    });
    PlaceReader reader(set, tags, static_cast<std::uint32_t>(groups.size()), worst_orientation);
    for (std::uint32_t i = 0; i < groups.size(); ++i) {
        ANATOMESH_CHECK_STATUS(check_shared_orientation(set, groups[i], tags, i));
        const auto at = each_its_own ? groups[i].own(tags.position_group, tags.position)
                                     : groups[i].shared(tags.position_group, tags.position);
        ANATOMESH_CHECK_STATUS(
            reader.read(at, groups[i].holder(tags.orientation_group, tags.orientation), found.frames[i]));
    }
    found.known_axes = tags.is_text;
    return Nothing{};
}

bool is_reconstructed_nuclear(const DicomItem& root) {
    return root.text(tags::sop_class) == "1.2.840.10008.5.1.4.1.1.20" &&
           root.text(tags::image_type).find("RECON") != std::string_view::npos;
}

// The item that says the place of the first frame.
std::optional<DicomItem> first_place(const DicomItem& root) {
    if (root.find(tags::image_position)) return root;
    const auto detector = root.item(tags::detector_information_sequence);
    if (detector && detector->find(tags::image_position) && is_reconstructed_nuclear(root)) return detector;
    return std::nullopt;
}

// How far the frames of reconstructed nuclear medicine lie from the first, along its normal; empty: it does not say.
Result<std::vector<double>> nuclear_offsets(const DicomItem& root, std::size_t count) {
    ANATOMESH_TRY(const auto spacing, decimal(root, tags::spacing_between_slices));
    ANATOMESH_TRY(const auto slices, unsigned_shorts(root, tags::slice_vector, count));
    std::vector<double> offsets;
    if (!spacing || *spacing == 0 || !slices) return offsets;
    for (const std::uint32_t slice : *slices) offsets.push_back((static_cast<double>(slice) - 1) * *spacing);
    return offsets;
}

// GridFrameOffsetVector: from the first frame when it begins with 0, else heights along z of axial frames.
Result<std::vector<double>> grid_offsets(const DicomItem& root, const DicomFrame& first, std::size_t count) {
    // Frames are axial, and heights equal, within this, because files round. [1 and mm; 0 to 0.1; D digits of files]
    constexpr double same_height = 1e-3;
    ANATOMESH_TRY(auto offsets, decimals(root, tags::grid_frame_offset_vector, count));
    if (!offsets || offsets->front() == 0) return offsets.value_or(std::vector<double>{});
    const double up = cross(first.row, first.column).z, start = offsets->front();
    if (std::abs(std::abs(up) - 1) > same_height || std::abs(start - first.position.z) > same_height)
        return bad_value(root, tags::grid_frame_offset_vector,
                         "begins neither with 0 nor with the height of the first frame");
    for (double& offset : *offsets) offset = (offset - start) * (up > 0 ? 1 : -1);
    return *offsets;
}

// Where along the patient a direction mostly leads.
const char* towards(Vec3 direction) {
    const std::array<double, 3> along{direction.x, direction.y, direction.z};
    constexpr const char* names[3][2] = {
        {"the right", "the left"}, {"the front", "the back"}, {"the feet", "the head"}};
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a)
        if (std::abs(along[a]) > std::abs(along[axis])) axis = a;
    return names[axis][along[axis] > 0];
}

Error unknown_step(const DataSet& set, const DicomFrame& first, std::size_t count) {
    const DicomItem root = set.root();
    std::string step = "MM", stated;
    for (const auto& [tag, name] : {std::pair{tags::spacing_between_slices, "SpacingBetweenSlices"},
                                    {tags::slice_thickness, "SliceThickness"}}) {
        const auto value = decimal(root, tag);
        if (!value.ok() || !value.value() || !(std::abs(*value.value()) > 0)) continue;
        step = number_text(std::abs(*value.value()));
        stated = fmt::format("{} {}", name, step);
        break;
    }
    const Vec3 normal = cross(first.row, first.column);
    return frame_error(
        "E-DCM-040", set, 0, 1,
        fmt::format(
            "the file says where the first of its {} frames lies, but not in which direction the others "
            "follow",
            count),
        stated,
        fmt::format("give --frame-step {} when each frame lies further towards {} than the one before, or "
                    "--frame-step=-{} when towards {}",
                    step, towards(normal), step, towards(-1.0 * normal)));
}

Status place_after_first(const DataSet& set, const FrameGroups& group, std::optional<double> step_mm,
                         FramesOfObject& found, double& worst_orientation) {
    const DicomItem root = set.root();
    const std::size_t count = found.frames.size();
    const auto first = first_place(root);
    PlaceReader reader(set, of_patient, static_cast<std::uint32_t>(count), worst_orientation);
    const bool has_orientation = first->find(of_patient.orientation) != nullptr;
    ANATOMESH_CHECK_STATUS(reader.read(
        first, has_orientation ? *first : group.holder(of_patient.orientation_group, of_patient.orientation),
        found.frames[0]));
    if (count == 1) return Nothing{};
    std::vector<double> offsets;
    if (is_reconstructed_nuclear(root)) {
        ANATOMESH_TRY(offsets, nuclear_offsets(root, count));
    } else {
        ANATOMESH_TRY(offsets, grid_offsets(root, found.frames[0], count));
    }
    if (offsets.empty()) {
        if (!step_mm) return unknown_step(set, found.frames[0], count);
        for (std::size_t i = 0; i < count; ++i) offsets.push_back(static_cast<double>(i) * *step_mm);
        found.by_step = true;
    }
    const DicomFrame start = found.frames[0];
    const Vec3 normal = cross(start.row, start.column);
    for (std::size_t i = 0; i < count; ++i) {
        found.frames[i].row = start.row;
        found.frames[i].column = start.column;
        const Vec3 at = start.position + (offsets[i] - offsets[0]) * normal;
        if (!is_in_bounds(at)) return reader.beyond(static_cast<std::uint32_t>(i), {at.x, at.y, at.z});
        found.frames[i].position = at;
    }
    return Nothing{};
}

}  // namespace

bool states_first_place(const DicomItem& root) {
    return first_place(root).has_value();
}

Status place_frames(const DataSet& set, const std::vector<FrameGroups>& groups, std::optional<double> step_mm,
                    FramesOfObject& found, double& worst_orientation) {
    for (const PlaceTags* tags : {&of_patient, &of_volume})
        if (groups_state_position(groups, *tags))
            return place_by_groups(set, groups, *tags, found, worst_orientation);
    if (!states_first_place(set.root()))
        return PlaceReader(set, of_patient, static_cast<std::uint32_t>(groups.size()), worst_orientation)
            .missing(0, of_patient.position_name);
    return place_after_first(set, groups[0], step_mm, found, worst_orientation);
}

void turn_ras_to_lps(std::vector<DicomFrame>& frames) {
    for (DicomFrame& frame : frames)
        for (Vec3* each : {&frame.position, &frame.row, &frame.column}) *each = {-each->x, -each->y, each->z};
}

}  // namespace anatomesh
