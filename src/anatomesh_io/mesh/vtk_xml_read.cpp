#include <expat.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <memory>
#include <optional>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/vtk_decode.h"
#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh {

namespace {

using Attributes = std::map<std::string, std::string, std::less<>>;

enum class Format : std::uint8_t { ascii, binary, appended };

// An array as the XML names it, before its numbers are decoded.
struct RawArray {
    VtkArray array;
    std::string section;  // the element around it: "Points", "PointData", "Lines" ...
    Format format = Format::ascii;
    std::uint64_t offset = 0;  // of an appended one
    std::string text;          // of an inline one
};

// What the XML says.
struct Document {
    std::string kind;  // "PolyData", "UnstructuredGrid"
    VtkEncoding encoding;
    std::vector<RawArray> arrays;
    Attributes piece;
    int pieces = 0;
    bool has_appended = false, appended_base64 = false;
    std::size_t appended_begin = 0;  // of the bytes after its tag
};

// Elements nested deeper are refused, so that a hostile file takes no memory. [levels; >= 6; B]
constexpr std::size_t max_depth = 32;
// The parser gets the file in chunks of this size, between which the run can be cancelled.
// [bytes; >= 4096; B]
constexpr std::size_t chunk_bytes = std::size_t{1} << 20;

std::optional<std::uint64_t> parse_count(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    std::uint64_t value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<VtkType> parse_type(std::string_view name) {
    constexpr std::array<std::pair<std::string_view, VtkType>, 12> types{{{"Int8", VtkType::int8},
                                                                          {"UInt8", VtkType::uint8},
                                                                          {"Int16", VtkType::int16},
                                                                          {"UInt16", VtkType::uint16},
                                                                          {"Int32", VtkType::int32},
                                                                          {"UInt32", VtkType::uint32},
                                                                          {"Int64", VtkType::int64},
                                                                          {"UInt64", VtkType::uint64},
                                                                          {"Float32", VtkType::float32},
                                                                          {"Float64", VtkType::float64},
                                                                          {"String", VtkType::string},
                                                                          {"vtkIdType", VtkType::int64}}};
    for (const auto& [known, type] : types) {
        if (known == name) return type;
    }
    return std::nullopt;
}

// Walks the XML with expat and keeps what matters. After the first error nothing more is taken.
class XmlWalk {
  public:
    XmlWalk(std::span<const std::byte> content, Document& document)
        : content_(content), document_(document), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {}

    Status run();

  private:
    static void start(void* self, const XML_Char* name, const XML_Char** attributes) {
        static_cast<XmlWalk*>(self)->start_element(name, attributes);
    }
    static void end(void* self, const XML_Char*) {
        auto& walk = *static_cast<XmlWalk*>(self);
        if (!walk.open_.empty()) walk.open_.pop_back();
    }
    static void characters(void* self, const XML_Char* text, int size) {
        auto& walk = *static_cast<XmlWalk*>(self);
        if (!walk.open_.empty() && (walk.open_.back() == "DataArray" || walk.open_.back() == "Array") &&
            !walk.document_.arrays.empty()) {
            walk.document_.arrays.back().text.append(text, static_cast<std::size_t>(size));
        }
    }
    static void document_type(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
        auto& walk = *static_cast<XmlWalk*>(self);
        walk.fail(vtk_error("E-VTK-001", "the file declares a document type, which VTK files must not have",
                            walk.document_.encoding.path));
    }

    void start_element(std::string name, const XML_Char** attributes);
    void file_element(const Attributes& attributes);
    void array_element(const Attributes& attributes);
    void appended_element(const Attributes& attributes);

    void fail(Error error) {
        if (!failure_) {
            error.place.value = "line " + std::to_string(XML_GetCurrentLineNumber(parser_.get()));
            failure_ = std::move(error);
        }
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    std::span<const std::byte> content_;
    Document& document_;
    std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser_;
    std::vector<std::string> open_;  // the elements around the current place
    std::optional<Error> failure_;
};

std::string attribute(const Attributes& attributes, std::string_view name, std::string otherwise = {}) {
    const auto found = attributes.find(name);
    return found == attributes.end() ? std::move(otherwise) : found->second;
}

Status XmlWalk::run() {
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &XmlWalk::start, &XmlWalk::end);
    XML_SetCharacterDataHandler(parser_.get(), &XmlWalk::characters);
    XML_SetStartDoctypeDeclHandler(parser_.get(), &XmlWalk::document_type);
    for (std::size_t at = 0;; at += chunk_bytes) {
        const std::size_t size = std::min(chunk_bytes, content_.size() - std::min(at, content_.size()));
        const bool last = at + size >= content_.size();
        const XML_Status status =
            XML_Parse(parser_.get(), size > 0 ? reinterpret_cast<const char*>(content_.data() + at) : "",
                      static_cast<int>(size), last);
        if (failure_) return *failure_;
        if (document_.has_appended) return Nothing{};
        if (status != XML_STATUS_OK) {
            Error error = vtk_error(
                "E-VTK-001",
                std::string("the file is no valid XML: ") + XML_ErrorString(XML_GetErrorCode(parser_.get())),
                document_.encoding.path);
            error.place.value = "line " + std::to_string(XML_GetCurrentLineNumber(parser_.get()));
            return error;
        }
        if (last) return Nothing{};
    }
}

void XmlWalk::start_element(std::string name, const XML_Char** list) {
    // expat may call on for the rest of a chunk after it was stopped.
    if (failure_ || document_.has_appended) return;
    Attributes attributes;
    for (; *list; list += 2) attributes.emplace(list[0], list[1]);
    if (open_.size() >= max_depth) {
        fail(vtk_error("E-VTK-001", "elements are nested too deeply", document_.encoding.path));
    } else if (open_.empty()) {
        if (name == "VTKFile") {
            file_element(attributes);
        } else {
            fail(vtk_error("E-VTK-002", "the file is no VTK file: it begins with the element " + name,
                           document_.encoding.path));
        }
    } else if (name == "Piece") {
        document_.piece = attributes;
        if (++document_.pieces > 1) {
            Error error = vtk_error("E-VTK-009", "the file has several pieces", document_.encoding.path);
            error.next_step = "join them into one first (ParaView: Merge Blocks)";
            fail(std::move(error));
        }
    } else if (name == "DataArray" || name == "Array") {
        array_element(attributes);
    } else if (name == "AppendedData") {
        appended_element(attributes);
    }
    open_.push_back(std::move(name));
}

void XmlWalk::file_element(const Attributes& attributes) {
    VtkEncoding& encoding = document_.encoding;
    document_.kind = attribute(attributes, "type");
    const std::string order = attribute(attributes, "byte_order", "LittleEndian");
    const std::string header = attribute(attributes, "header_type", "UInt32");
    const std::string compressor = attribute(attributes, "compressor");
    encoding.little_endian = order == "LittleEndian";
    encoding.wide_header = header == "UInt64";
    encoding.compressed = !compressor.empty();
    if (document_.kind != "PolyData" && document_.kind != "UnstructuredGrid") {
        fail(vtk_error("E-VTK-002",
                       "the VTK file holds " + document_.kind + ", not PolyData or UnstructuredGrid",
                       encoding.path));
    } else if (!encoding.little_endian && order != "BigEndian") {
        fail(vtk_error("E-VTK-003", "unknown byte_order " + order, encoding.path));
    } else if (!encoding.wide_header && header != "UInt32") {
        fail(vtk_error("E-VTK-003", "unknown header_type " + header, encoding.path));
    } else if (encoding.compressed && compressor != "vtkZLibDataCompressor") {
        Error error =
            vtk_error("E-VTK-011", "the program does not read the compression " + compressor, encoding.path);
        error.next_step = "write the file with vtkZLibDataCompressor";
        fail(std::move(error));
    }
}

void XmlWalk::array_element(const Attributes& attributes) {
    const std::string& path = document_.encoding.path;
    RawArray raw;
    raw.section = open_.back();
    raw.array.name = attribute(attributes, "Name");
    const auto type = parse_type(attribute(attributes, "type"));
    const auto components = parse_count(attribute(attributes, "NumberOfComponents", "1"));
    const auto offset = parse_count(attribute(attributes, "offset", "0"));
    const std::string format = attribute(attributes, "format", "ascii");
    if (!type || !components || *components > 1000 || !offset ||
        (format != "ascii" && format != "binary" && format != "appended")) {
        fail(vtk_error("E-VTK-003", "an attribute is missing or out of range", path, raw.array.name));
        return;
    }
    raw.array.type = *type;
    raw.array.components = static_cast<std::uint32_t>(std::max<std::uint64_t>(*components, 1));
    raw.offset = *offset;
    raw.format = format == "ascii" ? Format::ascii : format == "binary" ? Format::binary : Format::appended;
    document_.arrays.push_back(std::move(raw));
}

void XmlWalk::appended_element(const Attributes& attributes) {
    document_.has_appended = true;
    document_.appended_base64 = attribute(attributes, "encoding", "base64") == "base64";
    document_.appended_begin = static_cast<std::size_t>(XML_GetCurrentByteIndex(parser_.get())) +
                               static_cast<std::size_t>(XML_GetCurrentByteCount(parser_.get()));
    XML_StopParser(parser_.get(), XML_FALSE);
}

// The bytes after the underscore that begins the appended data; nothing when there is none.
std::optional<std::string_view> appended_data(std::span<const std::byte> content, const Document& document) {
    if (!document.has_appended || document.appended_begin > content.size()) return std::nullopt;
    std::string_view data = as_text(content.subspan(document.appended_begin));
    const std::size_t first = data.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || data[first] != '_') return std::nullopt;
    return data.substr(first + 1);
}

Status decode(RawArray& raw, const Document& document, std::optional<std::string_view> appended,
              std::uint64_t& inflated) {
    VtkArray& array = raw.array;
    const VtkEncoding& encoding = document.encoding;
    if (raw.format == Format::ascii) {
        ANATOMESH_CHECK_STATUS(decode_ascii(array, raw.text, encoding));
    } else if (raw.format == Format::binary) {
        ANATOMESH_CHECK_STATUS(decode_binary(array, raw.text, true, encoding, inflated));
    } else if (!appended || raw.offset > appended->size()) {
        return vtk_error("E-VTK-004", "the array begins beyond the end of the file", encoding.path,
                         array.name);
    } else {
        ANATOMESH_CHECK_STATUS(
            decode_binary(array, appended->substr(raw.offset), document.appended_base64, encoding, inflated));
    }
    raw.text = {};
    if (array.bytes.size() % (byte_size(array.type) * array.components) != 0) {
        return vtk_error("E-VTK-006", "the array's size is not a multiple of its components", encoding.path,
                         array.name);
    }
    return Nothing{};
}

// Puts the decoded arrays where they belong and checks that they fit together.
class Assembly {
  public:
    Assembly(Document& document, VtkFile& file) : document_(document), file_(file) {}
    Status run();

  private:
    const std::string& path() const { return document_.encoding.path; }

    const VtkArray* find(std::string_view section, std::string_view name) const {
        for (const RawArray& raw : document_.arrays) {
            if (raw.section == section && (name.empty() || raw.array.name == name)) return &raw.array;
        }
        return nullptr;
    }
    Status take_points();
    Status take_cells(const char* section, const char* count, VtkCells& cells);
    Status take_types();
    Status take_data(const char* section, std::size_t tuples, std::vector<VtkArray>& data);
    Status check_count(const char* attribute_name, std::size_t count) const;

    Document& document_;
    VtkFile& file_;
};

Status Assembly::check_count(const char* name, std::size_t count) const {
    const auto found = document_.piece.find(name);
    if (found == document_.piece.end()) return Nothing{};
    if (parse_count(found->second) != count) {
        return vtk_error("E-VTK-006",
                         std::string(name) + " says " + found->second.substr(0, 40) + ", there are " +
                             std::to_string(count),
                         path());
    }
    return Nothing{};
}

Status Assembly::take_points() {
    if (const VtkArray* array = find("Points", "")) {
        if (array->type == VtkType::string || array->components != 3) {
            return vtk_error("E-VTK-006", "points need three numbers each", path(), array->name);
        }
        const std::vector<double> values = array->to_doubles();
        file_.points.resize(values.size() / 3);
        for (std::size_t i = 0; i < file_.points.size(); ++i) {
            file_.points[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
        }
    }
    return check_count("NumberOfPoints", file_.points.size());
}

Status Assembly::take_cells(const char* section, const char* count, VtkCells& cells) {
    const VtkArray* connectivity = find(section, "connectivity");
    const VtkArray* offsets = find(section, "offsets");
    if (!connectivity != !offsets) {
        return vtk_error("E-VTK-008", std::string(section) + " needs the arrays connectivity and offsets",
                         path());
    }
    if (connectivity) {
        if (connectivity->type == VtkType::string || offsets->type == VtkType::string) {
            return vtk_error("E-VTK-003", "cells need whole numbers", path(), section);
        }
        cells.connectivity = connectivity->to_integers();
        cells.offsets = offsets->to_integers();
    }
    std::int64_t before = 0;
    for (const std::int64_t offset : cells.offsets) {
        if (offset < before || static_cast<std::uint64_t>(offset) > cells.connectivity.size()) {
            return vtk_error("E-VTK-012",
                             std::string("the offsets of ") + section + " do not fit its connectivity",
                             path());
        }
        before = offset;
    }
    if (static_cast<std::uint64_t>(before) != cells.connectivity.size()) {
        return vtk_error("E-VTK-012",
                         std::string("the offsets of ") + section + " do not fit its connectivity", path());
    }
    for (std::size_t i = 0; i < cells.connectivity.size(); ++i) {
        if (static_cast<std::uint64_t>(cells.connectivity[i]) >= file_.points.size()) {
            Error error = vtk_error("E-VTK-007",
                                    std::string("entry ") + std::to_string(i) + " of " + section +
                                        " names a point that does not exist (there are " +
                                        std::to_string(file_.points.size()) + ")",
                                    path());
            error.place.value = std::to_string(cells.connectivity[i]);
            return error;
        }
    }
    return check_count(count, cells.size());
}

Status Assembly::take_types() {
    const VtkArray* types = find("Cells", "types");
    if (types && types->type != VtkType::string) {
        for (const std::int64_t type : types->to_integers()) {
            if (type < 0 || type > 255) return vtk_error("E-VTK-003", "unknown cell type", path(), "types");
            file_.types.push_back(static_cast<std::uint8_t>(type));
        }
    }
    if (file_.types.size() != file_.cells.size()) {
        return vtk_error("E-VTK-006",
                         std::to_string(file_.types.size()) + " types for " +
                             std::to_string(file_.cells.size()) + " cells",
                         path(), "types");
    }
    return Nothing{};
}

Status Assembly::take_data(const char* section, std::size_t tuples, std::vector<VtkArray>& data) {
    for (RawArray& raw : document_.arrays) {
        if (raw.section != section) continue;
        if (raw.array.type != VtkType::string && raw.array.tuples() != tuples) {
            return vtk_error("E-VTK-006",
                             "the array has " + std::to_string(raw.array.tuples()) + " tuples, " +
                                 std::to_string(tuples) + " are needed",
                             path(), raw.array.name);
        }
        data.push_back(std::move(raw.array));
    }
    return Nothing{};
}

Status Assembly::run() {
    file_.kind = document_.kind == "PolyData" ? VtkDataSet::poly_data : VtkDataSet::unstructured_grid;
    ANATOMESH_CHECK_STATUS(take_points());
    if (file_.kind == VtkDataSet::unstructured_grid) {
        ANATOMESH_CHECK_STATUS(take_cells("Cells", "NumberOfCells", file_.cells));
        ANATOMESH_CHECK_STATUS(take_types());
    } else {
        ANATOMESH_CHECK_STATUS(take_cells("Verts", "NumberOfVerts", file_.verts));
        ANATOMESH_CHECK_STATUS(take_cells("Lines", "NumberOfLines", file_.lines));
        ANATOMESH_CHECK_STATUS(take_cells("Strips", "NumberOfStrips", file_.strips));
        ANATOMESH_CHECK_STATUS(take_cells("Polys", "NumberOfPolys", file_.polys));
    }
    ANATOMESH_CHECK_STATUS(take_data("PointData", file_.points.size(), file_.point_data));
    ANATOMESH_CHECK_STATUS(take_data("CellData", file_.cell_count(), file_.cell_data));
    for (RawArray& raw : document_.arrays) {
        if (raw.section == "FieldData") file_.field_data.push_back(std::move(raw.array));
    }
    return Nothing{};
}

}  // namespace

Result<VtkFile> parse_vtk_xml(std::span<const std::byte> content, const std::string& path,
                              const InputLimits& limits) {
    Document document;
    document.encoding.path = path;
    document.encoding.limits = limits;
    document.encoding.file_bytes = content.size();
    ANATOMESH_CHECK_STATUS(XmlWalk(content, document).run());
    const auto appended = appended_data(content, document);
    std::uint64_t inflated = 0;
    for (RawArray& raw : document.arrays) {
        ANATOMESH_CHECK_STATUS(decode(raw, document, appended, inflated));
    }
    VtkFile file;
    ANATOMESH_CHECK_STATUS(Assembly(document, file).run());
    return file;
}

}  // namespace anatomesh
