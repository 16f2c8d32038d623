// DICOM segmentations written frame by frame, good and bad, for the tests of this room.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh_io/dicom/dicom_fixtures.h"

namespace anatomesh::fixtures {

struct SegFrame {
    Vec3 position;
    std::uint16_t segment = 1;
    std::vector<std::uint16_t> pixels;               // of columns x rows: 0 and 1, a share of 255, or a label
    std::optional<std::pair<Vec3, Vec3>> axes = {};  // of the frame, beside or instead of the shared ones
};

struct SegFile {
    std::string type = "BINARY";
    std::uint16_t columns = 5, rows = 3, bits = 1;
    std::vector<std::uint16_t> segments{1};  // numbers declared
    std::vector<SegFrame> frames;
    std::optional<std::pair<Vec3, Vec3>> shared_axes = std::pair{Vec3{1, 0, 0}, Vec3{0, 1, 0}};
    std::string spacing = "0.5\\2", thickness = "3";
    std::optional<std::string> pixel_data = {};  // instead of that of the frames

    // Frames 3 mm apart, all inside.
    static SegFile stack(int count) {
        SegFile file;
        for (int k = 0; k < count; ++k)
            file.frames.push_back({{0, 0, 3.0 * k}, 1, std::vector<std::uint16_t>(15, 1)});
        return file;
    }

    std::string packed() const {
        std::string bytes;
        std::size_t bit = 0;
        for (const SegFrame& frame : frames)
            for (const std::uint16_t value : frame.pixels) {
                if (bits > 1) {
                    bytes += short_bytes({value}, bits / 8);
                    continue;
                }
                if (bit % 8 == 0) bytes += '\0';
                if (value) bytes.back() = static_cast<char>(bytes.back() | 1 << bit % 8);
                ++bit;
            }
        return bytes;
    }

    static void write_axes(DicomWriter& writer, const std::pair<Vec3, Vec3>& axes) {
        const auto& [row, column] = axes;
        writer.begin_sequence(tags::plane_orientation_sequence);
        writer.begin_item();
        writer.element(tags::image_orientation, "DS",
                       numbers({row.x, row.y, row.z, column.x, column.y, column.z}));
        writer.end_item();
        writer.end_sequence();
    }

    // `syntax_uid`: stated instead of explicit little endian.
    std::string bytes(const std::string& syntax_uid = {}) const {
        const std::string sop_class =
            type == "LABELMAP" ? "1.2.840.10008.5.1.4.1.1.66.7" : "1.2.840.10008.5.1.4.1.1.66.4";
        DicomWriter writer(DicomWriter::Syntax::explicit_little);
        writer.element(tags::sop_class, "UI", sop_class);
        writer.element(tags::sop_instance, "UI", "1.2.3.9");
        writer.element(tags::modality, "CS", "SEG");
        writer.element(tags::patient_name, "PN", "Planted^Name");
        writer.element(tags::study_instance, "UI", "1.2.3.1");
        writer.element(tags::series_instance, "UI", "1.2.3.8");
        writer.element(tags::frame_of_reference, "UI", "1.2.3.3");
        writer.unsigned_short(tags::samples_per_pixel, {1});
        writer.element(tags::photometric, "CS", "MONOCHROME2");
        writer.whole_number(tags::number_of_frames, static_cast<std::int64_t>(frames.size()));
        writer.unsigned_short(tags::rows, {rows});
        writer.unsigned_short(tags::columns, {columns});
        writer.unsigned_short(tags::bits_allocated, {bits});
        writer.unsigned_short(tags::bits_stored, {bits});
        writer.unsigned_short(tags::high_bit, {static_cast<std::uint16_t>(bits - 1)});
        writer.unsigned_short(tags::pixel_representation, {0});
        writer.element(tags::segmentation_type, "CS", type);
        writer.begin_sequence(tags::segment_sequence);
        for (const std::uint16_t number : segments) {
            writer.begin_item();
            writer.unsigned_short(tags::segment_number, {number});
            writer.element(tags::segment_label, "LO", "part " + std::to_string(number));
            writer.end_item();
        }
        writer.end_sequence();
        if (type == "FRACTIONAL") {
            writer.unsigned_short(tags::maximum_fractional_value, {255});
            writer.element(tags::fractional_type, "CS", "PROBABILITY");
        }
        writer.begin_sequence(tags::shared_groups);
        writer.begin_item();
        if (shared_axes) write_axes(writer, *shared_axes);
        writer.begin_sequence(tags::pixel_measures_sequence);
        writer.begin_item();
        writer.element(tags::slice_thickness, "DS", thickness);
        writer.element(tags::pixel_spacing, "DS", spacing);
        writer.end_item();
        writer.end_sequence();
        writer.end_item();
        writer.end_sequence();
        writer.begin_sequence(tags::per_frame_groups);
        for (const SegFrame& frame : frames) write_frame(writer, frame);
        writer.end_sequence();
        writer.element(tags::pixel_data, bits == 16 ? "OW" : "OB", pixel_data.value_or(packed()));
        std::string file = writer.file(sop_class, "1.2.3.9");
        if (!syntax_uid.empty()) {
            const std::string stated = std::string("1.2.840.10008.1.2.1") + '\0';
            const std::size_t at = file.find(stated);
            file.replace(at, stated.size(),
                         syntax_uid + std::string(stated.size() - syntax_uid.size(), '\0'));
        }
        return file;
    }

  private:
    void write_frame(DicomWriter& writer, const SegFrame& frame) const {
        writer.begin_item();
        writer.begin_sequence(tags::plane_position_sequence);
        writer.begin_item();
        writer.element(tags::image_position, "DS",
                       numbers({frame.position.x, frame.position.y, frame.position.z}));
        writer.end_item();
        writer.end_sequence();
        if (frame.axes) write_axes(writer, *frame.axes);
        if (type != "LABELMAP") {
            writer.begin_sequence(tags::segment_identification_sequence);
            writer.begin_item();
            writer.unsigned_short(tags::referenced_segment_number, {frame.segment});
            writer.end_item();
            writer.end_sequence();
        }
        writer.end_item();
    }
};

}  // namespace anatomesh::fixtures
