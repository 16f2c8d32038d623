// DICOM files written element by element, good and bad, for the tests of this room.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "anatomesh_io/dicom/dicom_writer.h"
#include "anatomesh_io/dicom/folder.h"
#include "anatomesh_io/dicom/read_series.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/image/image_fixtures.h"

namespace anatomesh::fixtures {

inline std::string short_bytes(const std::vector<std::int32_t>& values, int size = 2, bool big = false) {
    std::string bytes;
    for (const std::int32_t value : values)
        for (int b = 0; b < size; ++b)
            bytes += static_cast<char>(static_cast<std::uint32_t>(value) >> (8 * (big ? size - 1 - b : b)));
    return bytes;
}

inline std::string numbers(std::initializer_list<double> values) {
    std::string text;
    for (const double value : values) {
        if (!text.empty()) text += '\\';
        append_decimal_string(text, value);
    }
    return text;
}

// The elements of a CT slice by tag; every test changes what it is about.
struct SliceFile {
    struct Value {
        std::string vr, bytes;
    };
    std::map<DicomTag, Value> elements;
    DicomWriter::Syntax syntax = DicomWriter::Syntax::explicit_little;

    void set(DicomTag tag, const std::string& vr, const std::string& value) { elements[tag] = {vr, value}; }
    void set_short(DicomTag tag, std::uint16_t value) { set(tag, "US", short_bytes({value})); }
    void remove(DicomTag tag) { elements.erase(tag); }
    std::string uid() const { return elements.at(tags::sop_instance).bytes; }

    std::string bytes() const {
        DicomWriter writer(syntax);
        for (const auto& [tag, value] : elements) writer.element(tag, value.vr.c_str(), value.bytes);
        return writer.file("1.2.840.10008.5.1.4.1.1.2", uid());
    }
};

// Slice k of a CT of `columns` x `rows` pixels: value 100 k + 10 j + i, slope 1, intercept -1000.
inline SliceFile ct_slice(int k, Vec3 position, std::uint16_t columns = 5, std::uint16_t rows = 4,
                          Vec3 row = {1, 0, 0}, Vec3 column = {0, 1, 0}) {
    SliceFile file;
    file.set(tags::sop_class, "UI", "1.2.840.10008.5.1.4.1.1.2");
    file.set(tags::sop_instance, "UI", "1.2.3.4." + std::to_string(k + 1));
    file.set(tags::modality, "CS", "CT");
    file.set(tags::patient_name, "PN", "Planted^Name");
    file.set(tags::patient_id, "LO", "PLANTED-ID");
    file.set(tags::study_instance, "UI", "1.2.3.1");
    file.set(tags::series_instance, "UI", "1.2.3.2");
    file.set(tags::frame_of_reference, "UI", "1.2.3.3");
    file.set(tags::instance_number, "IS", std::to_string(k + 1));
    file.set(tags::slice_thickness, "DS", "5");
    file.set(tags::image_position, "DS", numbers({position.x, position.y, position.z}));
    file.set(tags::image_orientation, "DS", numbers({row.x, row.y, row.z, column.x, column.y, column.z}));
    file.set_short(tags::samples_per_pixel, 1);
    file.set(tags::photometric, "CS", "MONOCHROME2");
    file.set_short(tags::rows, rows);
    file.set_short(tags::columns, columns);
    file.set(tags::pixel_spacing, "DS", "0.5\\2");
    file.set_short(tags::bits_allocated, 16);
    file.set_short(tags::bits_stored, 16);
    file.set_short(tags::high_bit, 15);
    file.set_short(tags::pixel_representation, 1);
    file.set(tags::rescale_intercept, "DS", "-1000");
    file.set(tags::rescale_slope, "DS", "1");
    std::vector<std::int32_t> values;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) values.push_back(100 * k + 10 * j + i);
    file.set(tags::pixel_data, "OW", short_bytes(values));
    return file;
}

// A series of axial slices 3 mm apart.
inline std::vector<SliceFile> ct_series(int count, double spacing = 3) {
    std::vector<SliceFile> files;
    for (int k = 0; k < count; ++k) files.push_back(ct_slice(k, {-10, -20, 30 + spacing * k}));
    return files;
}

inline std::string name_of_slice(int k) {
    return "folder/" + std::string(1, static_cast<char>('a' + k / 26)) + static_cast<char>('a' + k % 26);
}

// A folder with these files, read.
struct Reading {
    Folder disk;
    RunContext context;
    std::optional<DicomFolder> folder;
    std::optional<Result<LoadedImage>> image;
    std::optional<Error> folder_error;

    explicit Reading(const std::vector<SliceFile>& files = {}) {
        for (std::size_t k = 0; k < files.size(); ++k)
            disk.write(name_of_slice(static_cast<int>(k)), files[k].bytes());
    }
    void scan() {
        auto found = read_dicom_folder(disk.path("folder"), {}, context);
        if (found.ok())
            folder = std::move(found).value();
        else
            folder_error = found.error();
    }
    // All images of the first series.
    Result<LoadedImage>& read(const ReadSeriesOptions& options = {}) {
        scan();
        for (const DicomSeries& series : folder->series) {
            if (series.kind != DicomKind::image) continue;
            image.emplace(read_dicom_series(*folder, series.objects, options, context));
            return *image;
        }
        image.emplace(Error{ErrorKind::input, "none", "no images", {}, ""});
        return *image;
    }
    std::string code(const ReadSeriesOptions& options = {}) {
        const auto& result = read(options);
        return result.ok() ? "" : result.error().code;
    }
    bool warned(const std::string& code) const {
        for (const Warning& warning : context.warnings)
            if (warning.code == code) return true;
        return false;
    }
    std::string line() const { return image->ok() ? "" : to_line(image->error()); }
    std::string warnings() const {
        std::string text;
        for (const Warning& warning : context.warnings) text += to_line(warning) + "\n";
        return text;
    }
};

}  // namespace anatomesh::fixtures
