#include "anatomesh_io/contour/vtp_contours.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "anatomesh_io/contour/drawn_structures.h"
#include "anatomesh_io/contour/number_text.h"
#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh {

namespace {

namespace fs = std::filesystem;

// An array of numbers, and one of text, or nothing where there is none of the kind.
std::vector<double> numbers(const VtkArray* array) {
    return array && array->type != VtkType::string ? array->to_doubles() : std::vector<double>{};
}
std::vector<std::string> texts(const VtkArray* array) {
    return array && array->type == VtkType::string ? array->to_strings() : std::vector<std::string>{};
}
std::string first_text(const VtkArray* array) {
    std::vector<std::string> all = texts(array);
    return all.empty() ? std::string{} : std::move(all.front());
}

const VtkArray* first_number_array(const VtkFile& file, std::initializer_list<const char*> names) {
    for (const char* name : names) {
        const VtkArray* array = file.cell_array(name);
        if (array && array->type != VtkType::string && array->components == 1) return array;
    }
    return nullptr;
}

std::optional<std::int32_t> whole_number(double value) {
    if (!(value >= -2147483648.0 && value <= 2147483647.0) || value != std::floor(value)) return std::nullopt;
    return static_cast<std::int32_t>(value);
}

// From 0 to 1, as VTK's colours are.
std::uint8_t color_byte(double share) {
    return static_cast<std::uint8_t>(
        std::lround(255.0 * std::clamp(std::isnan(share) ? 0.0 : share, 0.0, 1.0)));
}

class VtpReader {
  public:
    VtpReader(const VtkFile& file, const std::string& path, const std::string& prefix, std::int32_t number,
              RawBuilder& builder)
        : file_(file), path_(path), prefix_(prefix), number_(number), builder_(builder) {}

    Status read(bool is_first) {
        ANATOMESH_CHECK_STATUS(check_contents());
        ANATOMESH_CHECK_STATUS(read_frame(is_first));
        ANATOMESH_CHECK_STATUS(read_structures());
        ANATOMESH_CHECK_STATUS(read_planes());
        const std::size_t first_line = file_.verts.size();
        const std::size_t first_polygon = first_line + file_.lines.size() + file_.strips.size();
        for (std::size_t i = 0; i < file_.lines.size(); ++i) {
            ANATOMESH_CHECK_STATUS(
                read_cell(file_.lines.points_of(i), first_line + i, "line " + std::to_string(i), false));
        }
        for (std::size_t i = 0; i < file_.polys.size(); ++i) {
            ANATOMESH_CHECK_STATUS(
                read_cell(file_.polys.points_of(i), first_polygon + i, "polygon " + std::to_string(i), true));
        }
        return Nothing{};
    }

  private:
    Status check_contents() {
        const std::string unit = first_text(file_.field("unit"));
        if (!unit.empty() && unit != "mm")
            return failure("E-VTP-001", "the unit of the file is not mm", shown(unit),
                           "scale the file to millimetres");
        if (file_.strips.size() > 0 || is_surface())
            return failure("E-VTP-002", "the file holds a surface, not contours", {},
                           "give the contours, or cut the surface by planes first");
        const auto has_two = [](std::span<const std::int64_t> points) { return points.size() == 2; };
        std::size_t segments = 0;
        for (std::size_t i = 0; i < file_.lines.size(); ++i) segments += has_two(file_.lines.points_of(i));
        if (segments > 0 && segments == file_.lines.size() && file_.polys.size() == 0)
            return failure("E-VTP-003", "the lines are single segments, not polylines",
                           std::to_string(segments) + " lines", "join them, as vtkStripper does");
        if (file_.verts.size() > 0)
            builder_.context().warn({"W-VTP-001",
                                     "cells of single points are no contours",
                                     {path_, {}, {}, {}, {}},
                                     "they were left out"});
        return Nothing{};
    }

    // Triangles and quadrangles that share their points.
    bool is_surface() const {
        if (file_.polys.size() < 2) return false;
        for (std::size_t i = 0; i < file_.polys.size(); ++i)
            if (file_.polys.points_of(i).size() > 4) return false;
        return 2 * file_.polys.connectivity.size() > 3 * file_.points.size();
    }

    Status read_frame(bool is_first) {
        const std::string space = first_text(file_.field("SPACE"));
        const FileFrame frame = space == "LPS"   ? FileFrame::lps
                                : space == "RAS" ? FileFrame::ras
                                                 : FileFrame::unknown;
        if (!is_first && frame != builder_.frame)
            return failure("E-VTP-005",
                           "the axes of the file (frame) differ from those of the other files of the folder",
                           shown(space), "give the files one by one, with --frame");
        builder_.frame = frame;
        const std::vector<double> pixel = numbers(file_.field("pixel_mm"));
        if (!pixel.empty() && pixel[0] > 0 && pixel[0] <= 1e3) builder_.pixel_mm = pixel[0];
        const std::vector<double> thickness = numbers(file_.field("slice_thickness_mm"));
        if (!thickness.empty() && thickness[0] >= 1e-3 && thickness[0] <= 1e3)
            builder_.slice_thickness_mm = thickness[0];
        builder_.complete =
            (is_first || builder_.complete) && first_text(file_.field("coverage")) == "complete";
        // A file cannot speak of the structures of another.
        builder_.exclusive = is_first && first_text(file_.field("exclusive")) == "yes";
        return Nothing{};
    }

    Status read_structures() {
        cell_structures_ = numbers(first_number_array(file_, {"structure", "label", "labels"}));
        if (cell_structures_.empty()) return add_structure(whole_file());
        const std::vector<double> structure_numbers = numbers(file_.field("structure_number"));
        const std::vector<std::string> names = texts(file_.field("structure_name"));
        const std::vector<double> colors = numbers(file_.field("structure_color"));
        const std::size_t count = structure_numbers.size();
        if ((!names.empty() && names.size() != count) || (!colors.empty() && colors.size() != 3 * count))
            return failure("E-VTP-006",
                           "structure_number, structure_name and structure_color have different lengths", {},
                           "write the file again");
        for (std::size_t i = 0; i < count; ++i) {
            Structure structure;
            const auto number = whole_number(structure_numbers[i]);
            if (!number) return not_a_number("structure_number", structure_numbers[i]);
            structure.number = *number;
            if (!names.empty()) structure.name = names[i];
            for (std::size_t k = 0; !colors.empty() && k < 3; ++k) {
                const double part = colors[3 * i + k];
                structure.color[k] = static_cast<std::uint8_t>(part >= 0 && part <= 255 ? part : 0);
            }
            ANATOMESH_CHECK_STATUS(add_structure(std::move(structure)));
        }
        return Nothing{};
    }

    Structure whole_file() const {
        Structure structure;
        structure.number = number_;
        structure.name = first_text(file_.field("Segment_Name"));
        if (structure.name.empty()) structure.name = fs::path(path_).stem().string();
        const std::vector<double> color = numbers(file_.field("Segment_DefaultColor"));
        if (color.size() == 3)
            for (std::size_t i = 0; i < 3; ++i) structure.color[i] = color_byte(color[i]);
        return structure;
    }

    Status add_structure(Structure structure) {
        const std::int32_t number = structure.number;
        if (builder_.find_structure(number))
            return failure("E-VTP-004", "two structures have the same number", std::to_string(number),
                           "give every structure its own number");
        ANATOMESH_TRY([[maybe_unused]] const auto index, builder_.add_structure(std::move(structure)));
        return Nothing{};
    }

    Status read_planes() {
        const std::vector<double> origins = numbers(file_.field("slice_origin"));
        const std::vector<double> normals = numbers(file_.field("slice_normal"));
        const std::vector<std::string> names = texts(file_.field("slice_name"));
        const std::size_t count = origins.size() / 3;
        if (count == 0) return Nothing{};
        cell_slices_ = numbers(first_number_array(file_, {"slice"}));
        if (origins.size() != 3 * count || normals.size() != 3 * count ||
            (!names.empty() && names.size() != count) || cell_slices_.empty())
            return failure("E-VTP-006",
                           "slice_origin, slice_normal, slice_name and slice have different lengths", {},
                           "write the file again");
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3 origin{origins[3 * i], origins[3 * i + 1], origins[3 * i + 2]};
            const Vec3 normal{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
            bool changed = false;
            ANATOMESH_TRY(const auto plane,
                          builder_.add_plane(origin, normal,
                                             names.empty() ? std::string{} : valid_utf8(names[i], changed),
                                             {path_, std::to_string(i), {}, {}, {}}));
            planes_.push_back(static_cast<std::int32_t>(plane));
        }
        return Nothing{};
    }

    Status read_cell(std::span<const std::int64_t> points, std::size_t cell, const std::string& name,
                     bool is_polygon) {
        if (builder_.context().cancelled()) return cancelled_error();
        if (points.empty()) return Nothing{};
        ANATOMESH_TRY(const auto structure, structure_of(cell));
        std::int32_t plane = -1;
        if (!planes_.empty()) {
            const auto slice = whole_number(cell_slices_[cell]);
            if (!slice || *slice < 0 || static_cast<std::size_t>(*slice) >= planes_.size())
                return not_a_number("slice", cell_slices_[cell]);
            plane = planes_[static_cast<std::size_t>(*slice)];
        }
        const Vec3 first = file_.points[static_cast<std::size_t>(points.front())];
        const Vec3 last = file_.points[static_cast<std::size_t>(points.back())];
        const bool ends_where_it_begins = points.size() > 1 && first == last;
        const ContourKind kind = is_polygon || ends_where_it_begins ? ContourKind::closed_planar
                                 : points.size() == 1               ? ContourKind::point
                                                                    : ContourKind::open;
        if (ends_where_it_begins) points = points.first(points.size() - 1);
        ANATOMESH_CHECK_STATUS(builder_.begin_contour(structure, kind, plane, prefix_ + name));
        ANATOMESH_CHECK_STATUS(builder_.expect_points(points.size()));
        for (const std::int64_t point : points) {
            ANATOMESH_CHECK_STATUS(builder_.add_point(file_.points[static_cast<std::size_t>(point)]));
        }
        return Nothing{};
    }

    Result<std::uint32_t> structure_of(std::size_t cell) {
        if (cell_structures_.empty()) return *builder_.find_structure(number_);
        const auto number = whole_number(cell_structures_[cell]);
        if (!number) return not_a_number("structure", cell_structures_[cell]);
        return builder_.structure_of(*number);
    }

    Error not_a_number(const char* array, double value) const {
        std::string text;
        append_number(text, value);
        return failure("E-VTP-006", std::string("the array `") + array + "` holds an impossible value",
                       std::move(text), "write the file again");
    }
    Error failure(const char* code, std::string message, std::string value, const char* next) const {
        bool changed = false;
        return {ErrorKind::input,
                code,
                std::move(message),
                {path_, {}, {}, {}, valid_utf8(value, changed)},
                next};
    }

    const VtkFile& file_;
    const std::string& path_;
    const std::string& prefix_;
    std::int32_t number_;
    RawBuilder& builder_;
    std::vector<double> cell_structures_, cell_slices_;  // one per cell, or empty
    std::vector<std::int32_t> planes_;                   // in the builder, of each slice of the file
};

// Runs of digits compare as numbers, all else as characters.
bool natural_less(const std::string& a, const std::string& b) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (!is_digit(a[i]) || !is_digit(b[j])) {
            if (a[i] != b[j]) return a[i] < b[j];
            ++i, ++j;
            continue;
        }
        const auto end_of_digits = [&](const std::string& text, std::size_t at) {
            while (at < text.size() && is_digit(text[at])) ++at;
            return at;
        };
        const auto without_zeros = [](std::string_view digits) {
            return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
        };
        const std::size_t a_end = end_of_digits(a, i), b_end = end_of_digits(b, j);
        const std::string_view x = without_zeros(std::string_view(a).substr(i, a_end - i));
        const std::string_view y = without_zeros(std::string_view(b).substr(j, b_end - j));
        if (x.size() != y.size()) return x.size() < y.size();
        if (x != y) return x < y;
        i = a_end, j = b_end;
    }
    if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
    return a < b;
}

}  // namespace

Status read_vtp_contours(std::span<const std::byte> content, const std::string& path,
                         const std::string& prefix, std::int32_t number, const InputLimits& file_limits,
                         RawBuilder& builder) {
    ANATOMESH_TRY(const VtkFile file, parse_vtk_xml(content, path, file_limits));
    const bool is_first = builder.structures().empty();
    return VtpReader(file, path, prefix, number, builder).read(is_first);
}

Status read_vtp_folder(const std::string& folder, const InputLimits& file_limits, RawBuilder& builder) {
    std::vector<std::string> names;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        if (entry->path().extension() != ".vtp") continue;
        if (names.size() >= builder.limits().structures) return builder.too_many_structures();
        names.push_back(entry->path().filename().string());
    }
    if (names.empty())
        return Error{
            ErrorKind::input,
            "E-VTP-007",
            failed ? "the folder cannot be listed: " + failed.message() : "the folder holds no .vtp file",
            {folder, {}, {}, {}, {}},
            "give the file with the contours"};
    std::sort(names.begin(), names.end(), natural_less);
    std::int32_t number = 0;
    for (const std::string& name : names) {
        const std::string path = (fs::path(folder) / name).string();
        ANATOMESH_TRY(const InputFile file, read_input_file(path, file_limits));
        ANATOMESH_CHECK_STATUS(
            read_vtp_contours(file.bytes(), path, name + ", ", ++number, file_limits, builder));
    }
    return Nothing{};
}

std::string format_vtp_contours(const ContourSet& set, int threads) {
    VtkFile file;
    std::vector<std::int32_t> cell_structures, cell_slices;
    for (std::size_t s = 0; s < set.slices.size(); ++s) {
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            const std::size_t first = file.points.size();
            for (const Vec3& point : set.points_of(contour)) {
                file.lines.connectivity.push_back(static_cast<std::int64_t>(file.points.size()));
                file.points.push_back(point);
            }
            file.lines.connectivity.push_back(static_cast<std::int64_t>(first));
            file.lines.offsets.push_back(static_cast<std::int64_t>(file.lines.connectivity.size()));
            cell_structures.push_back(set.structures[contour.structure].number);
            cell_slices.push_back(static_cast<std::int32_t>(s));
        }
    }
    file.cell_data.push_back(VtkArray::of<std::int32_t>("structure", cell_structures));
    file.cell_data.push_back(VtkArray::of<std::int32_t>("slice", cell_slices));

    std::vector<std::int32_t> structure_numbers;
    std::vector<std::string> structure_names, slice_names;
    std::vector<std::uint8_t> colors;
    for (const std::uint32_t index : drawn_structures(set)) {
        const Structure& structure = set.structures[index];
        structure_numbers.push_back(structure.number);
        structure_names.push_back(structure.name);
        colors.insert(colors.end(), structure.color.begin(), structure.color.end());
    }
    std::vector<double> origins, normals;
    for (const Slice& slice : set.slices) {
        const Vec3 o = slice.plane.origin, n = slice.plane.normal;
        origins.insert(origins.end(), {o.x, o.y, o.z});
        normals.insert(normals.end(), {n.x, n.y, n.z});
        slice_names.push_back(slice.name);
    }
    const std::vector<std::string> space{set.frame == Frame::lps ? "LPS" : "unknown"}, unit{"mm"};
    file.field_data.push_back(VtkArray::of_strings("SPACE", space));
    file.field_data.push_back(VtkArray::of_strings("unit", unit));
    if (set.pixel_mm > 0) {
        const double pixel[] = {set.pixel_mm};
        file.field_data.push_back(VtkArray::of<double>("pixel_mm", pixel));
    }
    if (set.slice_thickness_mm > 0) {
        const double thickness[] = {set.slice_thickness_mm};
        file.field_data.push_back(VtkArray::of<double>("slice_thickness_mm", thickness));
    }
    if (set.complete) {
        const std::vector<std::string> coverage{"complete"};
        file.field_data.push_back(VtkArray::of_strings("coverage", coverage));
    }
    if (set.complete && set.exclusive) {
        const std::vector<std::string> exclusive{"yes"};
        file.field_data.push_back(VtkArray::of_strings("exclusive", exclusive));
    }
    file.field_data.push_back(VtkArray::of<std::int32_t>("structure_number", structure_numbers));
    file.field_data.push_back(VtkArray::of_strings("structure_name", structure_names));
    file.field_data.push_back(VtkArray::of<std::uint8_t>("structure_color", colors, 3));
    file.field_data.push_back(VtkArray::of<double>("slice_origin", origins, 3));
    file.field_data.push_back(VtkArray::of<double>("slice_normal", normals, 3));
    file.field_data.push_back(VtkArray::of_strings("slice_name", slice_names));
    return format_vtk_xml(file, "contours by anatomesh, SPACE=" + space[0] + ", unit mm",
                          {.threads = threads});
}

}  // namespace anatomesh
