#include "anatomesh_io/dicom/write_objects.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <utility>

#include "anatomesh_io/dicom/dicom_writer.h"
#include "anatomesh_io/dicom/lab_color.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/dicom/tags.h"

namespace anatomesh {

namespace {

constexpr const char* rtstruct_class = "1.2.840.10008.5.1.4.1.1.481.3";
constexpr const char* segmentation_class = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr const char* stl_class = "1.2.840.10008.5.1.4.1.1.104.3";
constexpr const char* obj_class = "1.2.840.10008.5.1.4.1.1.104.4";
constexpr const char *no_date = "19700101", *no_time = "000000";

using Syntax = DicomWriter::Syntax;

// The elements of an object in the order of their tags, whatever the order in which they are given.
class Composer {
  public:
    explicit Composer(Syntax syntax) : syntax_(syntax) {}

    void write(DicomTag tag, const std::function<void(DicomWriter&)>& write_element) {
        DicomWriter writer(syntax_);
        write_element(writer);
        elements_[tag] = writer.bytes();
    }
    void text(DicomTag tag, const char* vr, const std::string& value) {
        write(tag, [&](DicomWriter& writer) { writer.element(tag, vr, value); });
    }
    void number(DicomTag tag, std::int64_t value) { text(tag, "IS", std::to_string(value)); }
    void unsigned_short(DicomTag tag, std::uint16_t value) {
        write(tag, [&](DicomWriter& writer) { writer.unsigned_short(tag, {value}); });
    }
    // A sequence; `write_items` writes its items.
    void sequence(DicomTag tag, const std::function<void(DicomWriter&)>& write_items) {
        write(tag, [&](DicomWriter& writer) {
            writer.begin_sequence(tag);
            write_items(writer);
            writer.end_sequence();
        });
    }
    bool has(DicomTag tag) const { return elements_.contains(tag); }

    // The instance's UID comes from everything else.
    std::string file(const std::string& sop_class) {
        text(tags::sop_class, "UI", sop_class);
        elements_.erase(tags::sop_instance);
        std::string all;
        for (const auto& [tag, bytes] : elements_) all += bytes;
        const std::string instance = derived_uid(all);
        text(tags::sop_instance, "UI", instance);
        DicomWriter writer(syntax_);
        for (const auto& [tag, bytes] : elements_) writer.append(tag, bytes);
        return writer.file(sop_class, instance);
    }

  private:
    Syntax syntax_;
    std::map<DicomTag, std::string> elements_;
};

void write_code(DicomWriter& writer, DicomTag sequence, const char* value, const char* scheme,
                const char* meaning) {
    writer.begin_sequence(sequence);
    writer.begin_item();
    writer.element(tags::code_value, "SH", value);
    writer.element(tags::coding_scheme, "SH", scheme);
    writer.element(tags::code_meaning, "LO", meaning);
    writer.end_item();
    writer.end_sequence();
}

template <class Instance>
void write_reference(DicomWriter& writer, const Instance& instance) {
    writer.begin_item();
    writer.element(tags::referenced_sop_class, "UI", instance.sop_class);
    writer.element(tags::referenced_sop_instance, "UI", instance.sop_instance);
    writer.end_item();
}

// UIDs of a study that is not there are made from what is written.
struct Uids {
    std::string study, series, frame_of_reference;
};
Uids uids_of(const DicomSource& source, std::string_view content, const char* what) {
    Uids uids{source.study, {}, source.frame_of_reference};
    const std::string sum = sha256_text(content);
    if (uids.study.empty()) uids.study = derived_uid("study\n" + sum);
    if (uids.frame_of_reference.empty()) uids.frame_of_reference = derived_uid("frame of reference\n" + sum);
    uids.series = derived_uid(std::string("series\n") + what + "\n" + uids.study + "\n" + sum);
    return uids;
}

// Patient, study, series and equipment: the same in all objects.
void add_common(Composer& object, const DicomSource& source, const Uids& uids, const char* modality,
                const char* description) {
    object.text(tags::character_set, "CS",
                source.keeps_identity && !source.character_set.empty() ? source.character_set : "ISO_IR 192");
    object.text(tags::study_date, "DA", source.study_date);
    object.text(tags::study_time, "TM", source.study_time);
    object.text(tags::accession_number, "SH", source.accession);
    object.text(tags::modality, "CS", modality);
    object.text(tags::manufacturer, "LO", "anatomesh");
    object.text(tags::referring_physician, "PN", source.referring_physician);
    object.text(tags::series_description, "LO", description);
    object.text(tags::manufacturer_model, "LO", "anatomesh");
    object.text(tags::patient_name, "PN", source.patient_name);
    object.text(tags::patient_id, "LO", source.patient_id);
    object.text(tags::patient_birth_date, "DA", source.birth_date);
    object.text(tags::patient_sex, "CS", source.sex);
    if (!source.keeps_identity) {
        object.text(tags::patient_removed, "CS", "YES");
        object.text(tags::deidentification_method, "LO", "identity left out, UIDs replaced");
    }
    object.text(tags::device_serial, "LO", "0");
    object.text(tags::software_versions, "LO",
                source.software_version.empty() ? "anatomesh" : "anatomesh " + source.software_version);
    object.text(tags::study_instance, "UI", uids.study);
    object.text(tags::series_instance, "UI", uids.series);
    object.text(tags::study_id, "SH", source.study_id);
    object.number(tags::series_number, 1);
    object.text(tags::frame_of_reference, "UI", uids.frame_of_reference);
    object.text(tags::position_reference, "LO", "");
}

// ---- RT Structure Set

const DicomSource::Image* image_in_plane(const DicomSource& source, const Plane& plane) {
    for (const DicomSource::Image& image : source.images)
        if (image.frames == 1 && length(cross(image.normal, plane.normal)) < 1e-4 &&
            std::abs(dot(image.position - plane.origin, plane.normal)) < 0.01)
            return &image;
    return nullptr;
}

void write_frames_of_reference(DicomWriter& writer, const DicomSource& source, const Uids& uids) {
    writer.begin_item();
    writer.element(tags::frame_of_reference, "UI", uids.frame_of_reference);
    if (!source.images.empty()) {
        writer.begin_sequence(tags::rt_referenced_study_sequence);
        writer.begin_item();
        writer.element(tags::referenced_sop_class, "UI", "1.2.840.10008.3.1.2.3.1");
        writer.element(tags::referenced_sop_instance, "UI", uids.study);
        writer.begin_sequence(tags::rt_referenced_series_sequence);
        writer.begin_item();
        writer.element(tags::series_instance, "UI", source.series);
        writer.begin_sequence(tags::contour_image_sequence);
        for (const DicomSource::Image& image : source.images) write_reference(writer, image);
        writer.end_sequence();
        writer.end_item();
        writer.end_sequence();
        writer.end_item();
        writer.end_sequence();
    }
    writer.end_item();
}

void write_contour(DicomWriter& writer, const ContourSet& set, const Contour& contour,
                   const DicomSource::Image* image) {
    writer.begin_item();
    if (image) {
        writer.begin_sequence(tags::contour_image_sequence);
        write_reference(writer, *image);
        writer.end_sequence();
    }
    writer.element(tags::contour_geometric_type, "CS", "CLOSED_PLANAR");
    // The standard has retired it and names no other; without it a structure on one slice has no thickness.
    if (set.slice_thickness_mm > 0) writer.decimals(tags::contour_slab_thickness, {set.slice_thickness_mm});
    writer.whole_number(tags::number_of_contour_points, contour.point_count);
    std::string data;
    data.reserve(std::size_t{contour.point_count} * 48);
    for (const Vec3& point : set.points_of(contour))
        for (const double value : {point.x, point.y, point.z}) {
            if (!data.empty()) data += '\\';
            append_decimal_string(data, value);
        }
    writer.element(tags::contour_data, "DS", data);
    writer.end_item();
}

std::string color_text(const Structure& structure) {
    return std::to_string(structure.color[0]) + "\\" + std::to_string(structure.color[1]) + "\\" +
           std::to_string(structure.color[2]);
}

}  // namespace

std::string format_rtstruct(const ContourSet& set, const DicomSource& source) {
    Composer object(Syntax::implicit_little);
    std::vector<std::vector<std::uint32_t>> of_structure(set.structures.size());
    for (std::uint32_t c = 0; c < set.contours.size(); ++c)
        of_structure[set.contours[c].structure].push_back(c);
    std::vector<const DicomSource::Image*> image_of_slice;
    for (const Slice& slice : set.slices) image_of_slice.push_back(image_in_plane(source, slice.plane));

    object.sequence(tags::roi_contour_sequence, [&](DicomWriter& writer) {
        for (std::size_t s = 0; s < set.structures.size(); ++s) {
            writer.begin_item();
            writer.element(tags::roi_display_color, "IS", color_text(set.structures[s]));
            if (!of_structure[s].empty()) {
                writer.begin_sequence(tags::contour_sequence);
                for (const std::uint32_t c : of_structure[s])
                    write_contour(writer, set, set.contours[c], image_of_slice[set.contours[c].slice]);
                writer.end_sequence();
            }
            writer.whole_number(tags::referenced_roi_number, set.structures[s].number);
            writer.end_item();
        }
    });
    std::string content;
    for (const Vec3& point : set.points)
        for (const double value : {point.x, point.y, point.z}) append_decimal_string(content, value);
    const Uids uids = uids_of(source, content, "RTSTRUCT");
    add_common(object, source, uids, "RTSTRUCT", "contours");
    object.text({0x0008, 0x1070}, "PN", "");  // operators
    object.text(tags::structure_set_label, "SH", "anatomesh");
    object.text(tags::structure_set_date, "DA", source.study_date);
    object.text(tags::structure_set_time, "TM", source.study_time);
    object.sequence(tags::referenced_frame_sequence,
                    [&](DicomWriter& writer) { write_frames_of_reference(writer, source, uids); });
    object.sequence(tags::structure_set_roi_sequence, [&](DicomWriter& writer) {
        for (const Structure& structure : set.structures) {
            writer.begin_item();
            writer.whole_number(tags::roi_number, structure.number);
            writer.element(tags::roi_frame_of_reference, "UI", uids.frame_of_reference);
            writer.element(tags::roi_name, "LO", dicom_safe(structure.name, 64));
            writer.element(tags::roi_generation_algorithm, "CS", "");
            writer.end_item();
        }
    });
    object.sequence(tags::roi_observations_sequence, [&](DicomWriter& writer) {
        std::int64_t observation = 0;
        for (const Structure& structure : set.structures) {
            writer.begin_item();
            writer.whole_number(tags::observation_number, ++observation);
            writer.whole_number(tags::referenced_roi_number, structure.number);
            writer.element(tags::roi_interpreted_type, "CS", "");
            writer.element(tags::roi_interpreter, "PN", "");
            writer.end_item();
        }
    });
    return object.file(rtstruct_class);
}

// ---- Segmentation

namespace {

struct SegmentFrame {
    std::uint32_t structure, slice;
};

// The frames that are not empty, and their pixels, packed without gaps.
struct PackedFrames {
    std::vector<SegmentFrame> frames;
    std::string bits;
};
Result<PackedFrames> pack_frames(const VoxelModel& model) {
    const std::size_t pixels = std::size_t{model.geometry.size[0]} * model.geometry.size[1];
    std::vector<std::vector<std::uint8_t>> holds(model.structures.size(),
                                                 std::vector<std::uint8_t>(model.members.size(), 0));
    for (std::size_t r = 0; r < model.members.size(); ++r)
        for (const std::uint32_t s : model.members[r]) holds[s][r] = 1;
    PackedFrames packed;
    for (std::uint32_t s = 0; s < model.structures.size(); ++s)
        for (std::uint32_t k = 0; k < model.geometry.size[2]; ++k) {
            const std::uint16_t* voxels = model.regions.data() + k * pixels;
            bool is_empty = true;
            for (std::size_t i = 0; i < pixels && is_empty; ++i) is_empty = !holds[s][voxels[i]];
            if (!is_empty) packed.frames.push_back({s, k});
        }
    const std::size_t bytes = (packed.frames.size() * pixels + 7) / 8;
    ANATOMESH_CHECK_STATUS(check_value_length("the pixels of the segmentation", bytes));
    packed.bits.resize(bytes, '\0');
    std::size_t bit = 0;
    for (const SegmentFrame& frame : packed.frames) {
        const std::uint16_t* voxels = model.regions.data() + frame.slice * pixels;
        for (std::size_t i = 0; i < pixels; ++i, ++bit)
            if (holds[frame.structure][voxels[i]]) packed.bits[bit / 8] |= static_cast<char>(1 << bit % 8);
    }
    return packed;
}

void write_segments(DicomWriter& writer, const std::vector<Structure>& structures) {
    for (std::size_t s = 0; s < structures.size(); ++s) {
        const std::string name = structures[s].name.empty() ? std::to_string(structures[s].number)
                                                            : dicom_safe(structures[s].name, 64);
        writer.begin_item();
        write_code(writer, tags::segmented_category_sequence, "123037004", "SCT", "Anatomical Structure");
        writer.unsigned_short(tags::segment_number, {static_cast<std::uint16_t>(s + 1)});
        writer.element(tags::segment_label, "LO", name);
        writer.element(tags::segment_algorithm_type, "CS", "SEMIAUTOMATIC");
        writer.element(tags::segment_algorithm_name, "LO", "anatomesh");
        const auto lab = lab_of_color(structures[s].color);
        writer.unsigned_shorts(tags::recommended_color, lab);
        write_code(writer, tags::segmented_type_sequence, "85756007", "SCT", "Tissue");
        writer.end_item();
    }
}

void write_shared_groups(DicomWriter& writer, const ImageGeometry& geometry) {
    const Vec3 row = normalized(geometry.step[0]), column = normalized(geometry.step[1]);
    const double distance = std::abs(dot(geometry.step[2], cross(row, column)));
    writer.begin_item();
    writer.begin_sequence(tags::plane_orientation_sequence);
    writer.begin_item();
    writer.decimals(tags::image_orientation, {row.x, row.y, row.z, column.x, column.y, column.z});
    writer.end_item();
    writer.end_sequence();
    writer.begin_sequence(tags::pixel_measures_sequence);
    writer.begin_item();
    writer.decimals(tags::slice_thickness, {distance});
    writer.decimals(tags::spacing_between_slices, {distance});
    writer.decimals(tags::pixel_spacing, {length(geometry.step[1]), length(geometry.step[0])});
    writer.end_item();
    writer.end_sequence();
    writer.end_item();
}

// The image that a frame was drawn on.
void write_derivation(DicomWriter& writer, const DicomSource::Image& image) {
    writer.begin_sequence(tags::derivation_image_sequence);
    writer.begin_item();
    writer.begin_sequence(tags::source_image_sequence);
    writer.begin_item();
    writer.element(tags::referenced_sop_class, "UI", image.sop_class);
    writer.element(tags::referenced_sop_instance, "UI", image.sop_instance);
    write_code(writer, {0x0040, 0xA170}, "121322", "DCM", "Source image for image processing operation");
    writer.end_item();
    writer.end_sequence();
    write_code(writer, {0x0008, 0x9215}, "113076", "DCM", "Segmentation");
    writer.end_item();
    writer.end_sequence();
}

// The image of every slice of the grid; null where there is none.
std::vector<const DicomSource::Image*> images_of_slices(const ImageGeometry& grid,
                                                        const DicomSource& source) {
    const Vec3 normal = normalized(cross(grid.step[0], grid.step[1]));
    std::vector<const DicomSource::Image*> images;
    for (std::uint32_t k = 0; k < grid.size[2]; ++k)
        images.push_back(image_in_plane(source, {grid.position(0, 0, k), normal}));
    return images;
}

void write_frame_groups(DicomWriter& writer, const VoxelModel& model, const std::vector<SegmentFrame>& frames,
                        const std::vector<const DicomSource::Image*>& images) {
    for (const SegmentFrame& frame : frames) {
        const Vec3 at = model.geometry.position(0, 0, frame.slice);
        writer.begin_item();
        if (images[frame.slice]) write_derivation(writer, *images[frame.slice]);
        writer.begin_sequence(tags::frame_content_sequence);
        writer.begin_item();
        writer.unsigned_long(tags::dimension_index_values, {frame.structure + 1, frame.slice + 1});
        writer.end_item();
        writer.end_sequence();
        writer.begin_sequence(tags::plane_position_sequence);
        writer.begin_item();
        writer.decimals(tags::image_position, {at.x, at.y, at.z});
        writer.end_item();
        writer.end_sequence();
        writer.begin_sequence(tags::segment_identification_sequence);
        writer.begin_item();
        writer.unsigned_short(tags::referenced_segment_number,
                              {static_cast<std::uint16_t>(frame.structure + 1)});
        writer.end_item();
        writer.end_sequence();
        writer.end_item();
    }
}

void add_dimensions(Composer& object, const std::string& organization) {
    object.sequence(tags::dimension_organization_sequence, [&](DicomWriter& writer) {
        writer.begin_item();
        writer.element(tags::dimension_organization_uid, "UI", organization);
        writer.end_item();
    });
    object.sequence(tags::dimension_index_sequence, [&](DicomWriter& writer) {
        const std::pair<DicomTag, DicomTag> dimensions[] = {
            {tags::referenced_segment_number, tags::segment_identification_sequence},
            {tags::image_position, tags::plane_position_sequence}};
        for (const auto& [pointer, group] : dimensions) {
            writer.begin_item();
            writer.element(tags::dimension_organization_uid, "UI", organization);
            writer.tag_value(tags::dimension_index_pointer, pointer);
            writer.tag_value(tags::functional_group_pointer, group);
            writer.end_item();
        }
    });
}

void add_pixel_format(Composer& object, const ImageGeometry& geometry, std::size_t frames) {
    object.unsigned_short(tags::samples_per_pixel, 1);
    object.text(tags::photometric, "CS", "MONOCHROME2");
    object.number(tags::number_of_frames, static_cast<std::int64_t>(frames));
    object.unsigned_short(tags::rows, static_cast<std::uint16_t>(geometry.size[1]));
    object.unsigned_short(tags::columns, static_cast<std::uint16_t>(geometry.size[0]));
    object.unsigned_short(tags::bits_allocated, 1);
    object.unsigned_short(tags::bits_stored, 1);
    object.unsigned_short(tags::high_bit, 0);
    object.unsigned_short(tags::pixel_representation, 0);
    object.text(tags::lossy_compression, "CS", "00");
}

}  // namespace

Result<std::string> format_segmentation(const VoxelModel& model, const DicomSource& source) {
    assert(!model.structures.empty() && model.structures.size() <= 65535);
    ANATOMESH_TRY(const PackedFrames packed, pack_frames(model));
    Composer object(Syntax::explicit_little);
    const Uids uids = uids_of(source, packed.bits, "SEG");
    add_common(object, source, uids, "SEG", "model as voxels");
    object.text(tags::image_type, "CS", "DERIVED\\PRIMARY");
    object.number(tags::instance_number, 1);
    object.text(tags::content_date, "DA", source.study_date.empty() ? no_date : source.study_date);
    object.text(tags::content_time, "TM", source.study_time.empty() ? no_time : source.study_time);
    object.text(tags::content_label, "CS", "MODEL");
    object.text(tags::content_description, "LO", "");
    object.text(tags::content_creator, "PN", "");
    object.text(tags::segmentation_type, "CS", "BINARY");
    add_pixel_format(object, model.geometry, packed.frames.size());
    // Only what frames refer to is listed.
    const auto images = images_of_slices(model.geometry, source);
    std::vector<const DicomSource::Image*> referenced;
    for (const SegmentFrame& frame : packed.frames)
        if (images[frame.slice]) referenced.push_back(images[frame.slice]);
    std::sort(referenced.begin(), referenced.end());
    referenced.erase(std::unique(referenced.begin(), referenced.end()), referenced.end());
    if (!referenced.empty())
        object.sequence(tags::referenced_series_sequence, [&](DicomWriter& writer) {
            writer.begin_item();
            writer.begin_sequence(tags::referenced_instance_sequence);
            for (const DicomSource::Image* image : referenced) write_reference(writer, *image);
            writer.end_sequence();
            writer.element(tags::series_instance, "UI", source.series);
            writer.end_item();
        });
    add_dimensions(object, derived_uid("dimensions\n" + uids.series));
    object.sequence(tags::segment_sequence,
                    [&](DicomWriter& writer) { write_segments(writer, model.structures); });
    object.sequence(tags::shared_groups,
                    [&](DicomWriter& writer) { write_shared_groups(writer, model.geometry); });
    object.sequence(tags::per_frame_groups,
                    [&](DicomWriter& writer) { write_frame_groups(writer, model, packed.frames, images); });
    object.text(tags::pixel_data, "OB", packed.bits);
    return object.file(segmentation_class);
}

// ---- Encapsulated surfaces

namespace {

using Origins = std::span<const DicomSource::Origin>;

// Calls body(part) for every run of origins of which `key` is the same.
template <class Body>
void each_run(Origins origins, std::string DicomSource::Origin::*key, Body body) {
    for (std::size_t begin = 0, end = 0; begin < origins.size(); begin = end) {
        while (end < origins.size() && origins[end].*key == origins[begin].*key) ++end;
        body(origins.subspan(begin, end - begin));
    }
}

// One item a series, of origins in one study.
void write_series_items(DicomWriter& writer, Origins of_study) {
    each_run(of_study, &DicomSource::Origin::series, [&](Origins of_series) {
        writer.begin_item();
        writer.begin_sequence(tags::referenced_instance_sequence);
        for (const DicomSource::Origin& origin : of_series) write_reference(writer, origin);
        writer.end_sequence();
        writer.element(tags::series_instance, "UI", of_series[0].series);
        writer.end_item();
    });
}

// What the model is derived from, and where that is found: in this study, or in others.
void add_origins(Composer& object, Origins origins, const std::string& study) {
    if (origins.empty()) return;
    object.sequence(tags::source_instance_sequence, [&](DicomWriter& writer) {
        for (const DicomSource::Origin& origin : origins) write_reference(writer, origin);
    });
    std::vector<Origins> others;
    each_run(origins, &DicomSource::Origin::study, [&](Origins of_study) {
        if (of_study[0].study != study) return others.push_back(of_study);
        object.sequence(tags::referenced_series_sequence,
                        [&](DicomWriter& writer) { write_series_items(writer, of_study); });
    });
    if (others.empty()) return;
    object.sequence(tags::other_studies_sequence, [&](DicomWriter& writer) {
        for (const Origins of_study : others) {
            writer.begin_item();
            writer.begin_sequence(tags::referenced_series_sequence);
            write_series_items(writer, of_study);
            writer.end_sequence();
            writer.element(tags::study_instance, "UI", of_study[0].study);
            writer.end_item();
        }
    });
}

}  // namespace

Result<std::string> format_encapsulated(SurfaceObject kind, std::string_view surface,
                                        const std::string& title, const DicomSource& source) {
    ANATOMESH_CHECK_STATUS(check_value_length("the surface", surface.size()));
    const bool is_stl = kind == SurfaceObject::stl;
    Composer object(Syntax::explicit_little);
    const Uids uids = uids_of(source, surface, is_stl ? "STL" : "OBJ");
    add_common(object, source, uids, "M3D", "model surface");
    object.number(tags::instance_number, 1);
    object.text(tags::content_date, "DA", source.study_date);
    object.text(tags::content_time, "TM", source.study_time);
    object.text({0x0008, 0x002A}, "DT", "");  // AcquisitionDateTime
    object.text(tags::burned_in_annotation, "CS", "NO");
    object.text(tags::document_title, "ST", dicom_safe(title, 256));
    object.sequence(tags::concept_name_sequence, [](DicomWriter&) {});
    add_origins(object, source.origins, uids.study);
    object.text(tags::mime_type, "LO", is_stl ? "model/stl" : "model/obj");
    object.text(tags::encapsulated_document, "OB", std::string(surface));
    object.write(tags::encapsulated_length, [&](DicomWriter& writer) {
        writer.unsigned_long(tags::encapsulated_length, {static_cast<std::uint32_t>(surface.size())});
    });
    object.write(tags::unit_code_sequence, [](DicomWriter& writer) {
        write_code(writer, tags::unit_code_sequence, "mm", "UCUM", "mm");
    });
    object.text({0x0068, 0x7001}, "CS", "NO");  // ModelModification
    object.text({0x0068, 0x7002}, "CS", "NO");  // ModelMirroring
    return object.file(is_stl ? stl_class : obj_class);
}

Status check_value_length(const char* what, std::uint64_t bytes) {
    // Beyond it a length is none: odd ones are padded, and the largest number means that none is stated.
    // [bytes; 2^32 - 2; D DICOM PS3.5, section 7.1]
    constexpr std::uint64_t longest_value = 0xFFFFFFFEu;
    if (bytes <= longest_value) return Nothing{};
    return Error{ErrorKind::limit,
                 "E-DCM-045",
                 std::string(what) + " would take more than the 2^32 - 2 bytes that a DICOM element can hold",
                 {"", "", "", "", std::to_string(bytes) + " bytes"},
                 "write another format, make a coarser model, or write fewer structures at a time"};
}

}  // namespace anatomesh
