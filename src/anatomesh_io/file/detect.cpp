#include "anatomesh_io/file/detect.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

namespace {

// The format of a file is told from so many bytes at its start. [bytes; >= 512; B]
constexpr std::size_t start_bytes = 65536;

bool is_space(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

std::string_view without_leading_space(std::string_view text) {
    if (text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    return text;
}

bool starts_with(std::string_view text, std::string_view prefix) {
    return text.substr(0, prefix.size()) == prefix;
}

char upper(char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

bool starts_with_any_case(std::string_view text, std::string_view upper_prefix) {
    return text.size() >= upper_prefix.size() &&
           std::equal(upper_prefix.begin(), upper_prefix.end(), text.begin(),
                      [](char wanted, char found) { return wanted == upper(found); });
}

// The text after the key, when a line of the form "key = value" or "key" begins the text.
bool begins_with_key(std::string_view text, std::string_view key) {
    if (!starts_with(text, key)) return false;
    const std::string_view rest = text.substr(key.size());
    return rest.empty() || is_space(rest.front()) || rest.front() == '=' || rest.front() == ':';
}

// ---- binary kinds

bool is_nifti(std::span<const std::byte> start) {
    const std::string_view text = as_text(start);
    if (text.size() >= 348) {
        const std::string_view magic = text.substr(344, 4);
        if (magic == std::string_view("n+1\0", 4) || magic == std::string_view("ni1\0", 4)) return true;
    }
    if (text.size() >= 8) {
        const std::string_view magic = text.substr(4, 4);
        if (magic == std::string_view("n+2\0", 4) || magic == std::string_view("ni2\0", 4)) return true;
    }
    // A damaged one is still a NIfTI by its header size, so that the message can say what is wrong.
    ByteReader reader(start);
    const std::uint32_t size = reader.read<std::uint32_t>().value_or(0);
    return size == 348 || size == 540 || size == byte_swapped(std::uint32_t{348}) ||
           size == byte_swapped(std::uint32_t{540});
}

bool is_tar(std::string_view text) {
    return text.size() >= 512 && text.substr(257, 5) == "ustar";
}

bool is_binary_stl(std::span<const std::byte> start, std::string_view text) {
    // 80 bytes, a count, then 50 bytes a triangle whose last two are nearly always zero.
    if (text.size() < 84 + 50) return false;
    ByteReader reader(start);
    if (!reader.seek(80) || reader.read<std::uint32_t>().value_or(0) == 0) return false;
    const bool header_is_text = std::all_of(text.begin(), text.begin() + 80, [](char c) {
        return c == '\0' || (static_cast<unsigned char>(c) >= 0x20) || is_space(c);
    });
    std::size_t triangles = 0;
    for (std::size_t at = 84; at + 50 <= text.size() && triangles < 8; at += 50, ++triangles)
        if (text[at + 48] != '\0' || text[at + 49] != '\0') return false;
    return header_is_text;
}

// ---- text kinds

FileKind kind_of_xml(std::string_view text) {
    const std::size_t tag = text.find("<VTKFile");
    if (tag == std::string_view::npos) return FileKind::unknown;
    const std::string_view rest = text.substr(tag, text.find('>', tag) - tag);
    if (rest.find("\"PolyData\"") != std::string_view::npos) return FileKind::vtk_polydata;
    if (rest.find("\"UnstructuredGrid\"") != std::string_view::npos) return FileKind::vtk_unstructured_grid;
    return FileKind::unknown;
}

bool is_abaqus(std::string_view text) {
    // Comment lines begin with "**"; the first keyword decides.
    while (starts_with(text, "**")) {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return false;
        text = without_leading_space(text.substr(end + 1));
    }
    for (const char* keyword : {"*HEADING", "*NODE", "*PART", "*PREPRINT", "*INCLUDE", "*ELEMENT"})
        if (starts_with_any_case(text, keyword)) return true;
    return false;
}

bool is_metaimage(std::string_view text) {
    for (const char* key : {"ObjectType", "NDims", "Comment", "ElementDataFile", "DimSize", "ElementType"})
        if (begins_with_key(text, key) && text.find("NDims") != std::string_view::npos) return true;
    return false;
}

// Lines of Wavefront begin with a short keyword; the first that is no comment must be one of them.
bool is_obj(std::string_view text) {
    bool vertex = false;
    for (int line = 0; line < 4096 && !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size() - 1);
        const std::string_view current = without_leading_space(text.substr(0, end + 1));
        text = text.substr(end + 1);
        if (current.empty() || current.front() == '#') continue;
        const std::string_view word = current.substr(0, current.find_first_of(" \t\r\n"));
        constexpr std::array<std::string_view, 12> words = {"v", "vn", "vt", "vp", "f",      "l",
                                                            "p", "o",  "g",  "s",  "mtllib", "usemtl"};
        if (std::find(words.begin(), words.end(), word) == words.end()) return false;
        if (word == "v") vertex = true;
        if (vertex) return true;
    }
    return vertex;
}

FileKind kind_of_text(std::string_view text) {
    if (starts_with(text, "NRRD")) return FileKind::nrrd;
    if (starts_with(text, "CSLC")) return FileKind::csl;
    if (starts_with(text, "x\ty\tz\tcontour type\t")) return FileKind::guide_points;
    if (starts_with(text, "<")) return kind_of_xml(text);
    if (starts_with(text, "{")) return FileKind::contour_json;
    if (starts_with(text, "$MeshFormat") || starts_with(text, "$Comments")) return FileKind::gmsh;
    if (starts_with_any_case(text, "MESHVERSIONFORMATTED")) return FileKind::medit;
    if (begins_with_key(text, "solid") && text.find("facet") != std::string_view::npos) return FileKind::stl;
    if (starts_with(text, "ply\n") || starts_with(text, "ply\r")) return FileKind::ply;
    if (starts_with(text, "*") && is_abaqus(text)) return FileKind::abaqus;
    if (is_metaimage(text)) return FileKind::metaimage;
    if (is_obj(text)) return FileKind::obj;
    return FileKind::unknown;
}

// ---- DICOM

constexpr std::array<std::pair<const char*, const char*>, 4> sop_classes = {{
    {"1.2.840.10008.5.1.4.1.1.481.3", "RT Structure Set Storage"},
    {"1.2.840.10008.5.1.4.1.1.66.4", "Segmentation Storage"},
    {"1.2.840.10008.5.1.4.1.1.66.5", "Surface Segmentation Storage"},
    {"1.2.840.10008.5.1.4.1.1.66.7", "Label Map Segmentation Storage"},
}};

struct DicomElement {
    std::uint32_t tag = 0;
    std::string_view value;
};

bool is_upper(char c) {
    return c >= 'A' && c <= 'Z';
}

// One element at the reader's position, explicit or implicit VR; nothing when there is none whole.
std::optional<DicomElement> read_element(ByteReader& reader) {
    const auto group = reader.read<std::uint16_t>();
    const auto element = reader.read<std::uint16_t>();
    const auto representation = reader.read_text(2);
    if (!group || !element || !representation) return std::nullopt;
    std::optional<std::uint32_t> length;
    if (is_upper((*representation)[0]) && is_upper((*representation)[1])) {
        constexpr std::array<std::string_view, 11> wide = {"OB", "OD", "OF", "OL", "OV", "OW",
                                                           "SQ", "UC", "UN", "UR", "UT"};
        if (std::find(wide.begin(), wide.end(), *representation) != wide.end()) {
            if (reader.skip(2)) length = reader.read<std::uint32_t>();
        } else if (const auto narrow = reader.read<std::uint16_t>()) {
            length = *narrow;
        }
    } else {
        reader.seek(reader.position() - 2);
        length = reader.read<std::uint32_t>();
    }
    if (!length) return std::nullopt;
    const auto value = reader.read_text(*length);
    if (!value) return std::nullopt;
    return DicomElement{static_cast<std::uint32_t>(*group) << 16 | *element, *value};
}

bool has_preamble(std::string_view text) {
    return text.size() >= 132 && text.substr(128, 4) == "DICM";
}

// Whether the text begins like a data set without preamble: a first element of group 2 or 8 that is whole.
bool is_bare_dicom(std::span<const std::byte> start) {
    ByteReader reader(start);
    const auto element = read_element(reader);
    if (!element) return false;
    const std::uint32_t group = element->tag >> 16;
    return (group == 2 || group == 8) && (element->tag & 0xffff) <= 0x0070 && element->value.size() <= 256;
}

}  // namespace

const char* name_of(FileKind kind) {
    switch (kind) {
        case FileKind::unknown:
            return "unknown file";
        case FileKind::nifti:
            return "NIfTI image";
        case FileKind::nrrd:
            return "NRRD image";
        case FileKind::metaimage:
            return "MetaImage";
        case FileKind::invesalius:
            return "InVesalius project";
        case FileKind::dicom:
            return "DICOM file";
        case FileKind::dicom_rtstruct:
            return "DICOM RT structure set";
        case FileKind::dicom_segmentation:
            return "DICOM segmentation";
        case FileKind::contour_json:
            return "contours in JSON";
        case FileKind::csl:
            return "CSL contours";
        case FileKind::guide_points:
            return "cardiac guide points";
        case FileKind::vtk_polydata:
            return "VTK polydata";
        case FileKind::vtk_unstructured_grid:
            return "VTK unstructured grid";
        case FileKind::gmsh:
            return "Gmsh mesh";
        case FileKind::medit:
            return "Medit mesh";
        case FileKind::abaqus:
            return "Abaqus input";
        case FileKind::stl:
            return "STL surface";
        case FileKind::ply:
            return "PLY surface";
        case FileKind::obj:
            return "Wavefront surface";
    }
    return "";
}

std::string dicom_sop_class(std::span<const std::byte> start) {
    ByteReader reader(start);
    if (has_preamble(as_text(start)))
        reader.seek(132);
    else if (!is_bare_dicom(start))
        return {};
    while (const auto element = read_element(reader)) {
        // Media storage SOP class in the meta header, or the data set's own.
        if (element->tag == 0x00020002 || element->tag == 0x00080016) {
            std::string_view uid = element->value;
            while (!uid.empty() && (uid.back() == '\0' || uid.back() == ' ')) uid.remove_suffix(1);
            return std::string(uid);
        }
        if (element->tag > 0x00080016) break;
    }
    return {};
}

const char* dicom_sop_class_name(const std::string& uid) {
    for (const auto& [known, name] : sop_classes)
        if (uid == known) return name;
    return "";
}

FileKind detect_bytes(std::span<const std::byte> start) {
    std::vector<std::byte> inflated;
    if (is_gzip(start)) {
        inflated = inflate_start(start, start_bytes);
        start = inflated;
    }
    const std::string_view text = as_text(start);
    if (has_preamble(text) || is_bare_dicom(start)) {
        const std::string uid = dicom_sop_class(start);
        if (uid == sop_classes[0].first) return FileKind::dicom_rtstruct;
        return *dicom_sop_class_name(uid) ? FileKind::dicom_segmentation : FileKind::dicom;
    }
    if (is_tar(text)) return FileKind::invesalius;
    if (is_nifti(start)) return FileKind::nifti;
    if (const FileKind kind = kind_of_text(without_leading_space(text)); kind != FileKind::unknown)
        return kind;
    return is_binary_stl(start, text) ? FileKind::stl : FileKind::unknown;
}

Result<FileKind> detect(const std::string& path) {
    ANATOMESH_TRY(const std::vector<std::byte> start, read_input_start(path, start_bytes));
    return detect_bytes(start);
}

}  // namespace anatomesh
