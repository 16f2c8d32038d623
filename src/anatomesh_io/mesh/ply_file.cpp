// PLY: written binary little endian with double coordinates; read binary of either order or as text.
// Follows: Turk, "The PLY polygon file format", Stanford, 1994.
#include <algorithm>
#include <bit>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

enum class Type : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Type> type_of(std::string_view name) {
    if (name == "char" || name == "int8") return Type::int8;
    if (name == "uchar" || name == "uint8") return Type::uint8;
    if (name == "short" || name == "int16") return Type::int16;
    if (name == "ushort" || name == "uint16") return Type::uint16;
    if (name == "int" || name == "int32") return Type::int32;
    if (name == "uint" || name == "uint32") return Type::uint32;
    if (name == "float" || name == "float32") return Type::float32;
    if (name == "double" || name == "float64") return Type::float64;
    return std::nullopt;
}

std::size_t bytes_of(Type type) {
    constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

struct Property {
    std::string name;
    Type type = Type::float64;
    bool is_list = false;
    Type count_type = Type::uint8;
};

struct ElementKind {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

class PlyReader {
  public:
    PlyReader(const std::string& path, Bytes content) : path_(path), reader_(path), bytes_(content) {}
    Result<SurfaceFile> run(RunContext& context);

  private:
    Status header();
    Status header_line(std::string_view line, bool& more);
    Status property(std::string_view rest);
    Status element(const ElementKind& kind);
    Status keep(const ElementKind& kind);
    // The next value; nothing at the end, or when it is no number.
    std::optional<double> value(Type type);

    std::string place() const { return "byte " + std::to_string(bytes_.position()); }

    const std::string& path_;
    DescriptionReader reader_;
    ByteReader bytes_;
    bool text_ = false;
    std::vector<ElementKind> kinds_;
    // Of the element that is being read: one value per property, the items of its last list.
    std::vector<double> values_;
    std::vector<double> list_;
    SurfaceMesh mesh_;
    std::vector<std::int64_t> inner_, outer_;
    std::size_t polygons_ = 0;
};

Status PlyReader::property(std::string_view rest) {
    if (kinds_.empty()) return expected(path_, "an element before its properties", place());
    Property property;
    std::string_view type = take_word(rest);
    if (type == "list") {
        property.is_list = true;
        const auto count_type = type_of(take_word(rest));
        if (!count_type) return expected(path_, "the type of a list's length", place());
        property.count_type = *count_type;
        type = take_word(rest);
    }
    const auto known = type_of(type);
    if (!known) return expected(path_, "the type of a property", place());
    property.type = *known;
    property.name = std::string(take_word(rest));
    kinds_.back().properties.push_back(std::move(property));
    return Nothing{};
}

Status PlyReader::header_line(std::string_view line, bool& more) {
    const std::string_view word = take_word(line);
    if (word == "format") {
        const std::string_view format = take_word(line);
        text_ = format == "ascii";
        if (format == "binary_big_endian") {
            bytes_.set_order(std::endian::big);
        } else if (!text_ && format != "binary_little_endian") {
            return mesh_error("E-MDL-012", "unknown PLY format", path_, std::string(format.substr(0, 40)));
        }
    } else if (word == "comment") {
        return reader_.take(line);
    } else if (word == "element") {
        ElementKind kind;
        kind.name = std::string(take_word(line));
        const auto count = take_number<std::uint64_t>(line);
        if (!count) return expected(path_, "the number of elements", place());
        kind.count = *count;
        kinds_.push_back(std::move(kind));
    } else if (word == "property") {
        return property(line);
    } else if (word == "end_header") {
        more = false;
    }
    return Nothing{};
}

Status PlyReader::header() {
    for (bool more = true; more;) {
        const auto line = bytes_.read_line();
        if (!line) return expected(path_, "end_header", place());
        ANATOMESH_CHECK_STATUS(header_line(*line, more));
    }
    return Nothing{};
}

std::optional<double> PlyReader::value(Type type) {
    const auto widened = [](auto number) -> std::optional<double> {
        if (!number) return std::nullopt;
        return static_cast<double>(*number);
    };
    if (!text_) {
        switch (type) {
            case Type::int8:
                return widened(bytes_.read<std::int8_t>());
            case Type::uint8:
                return widened(bytes_.read<std::uint8_t>());
            case Type::int16:
                return widened(bytes_.read<std::int16_t>());
            case Type::uint16:
                return widened(bytes_.read<std::uint16_t>());
            case Type::int32:
                return widened(bytes_.read<std::int32_t>());
            case Type::uint32:
                return widened(bytes_.read<std::uint32_t>());
            case Type::float32:
                return widened(bytes_.read<float>());
            case Type::float64:
                break;
        }
        return bytes_.read<double>();
    }
    const auto blank = [](char c) { return is_blank(c) || c == '\n'; };
    const std::size_t begin = bytes_.position();
    const std::string_view rest = bytes_.read_text(bytes_.remaining()).value_or("");
    std::size_t first = 0;
    while (first < rest.size() && blank(rest[first])) ++first;
    std::size_t last = first;
    while (last < rest.size() && !blank(rest[last])) ++last;
    bytes_.seek(begin + last);
    return number_of<double>(rest.substr(first, last - first));
}

// Reads one element into values_ and list_.
Status PlyReader::element(const ElementKind& kind) {
    values_.clear();
    for (const Property& property : kind.properties) {
        const auto first = value(property.is_list ? property.count_type : property.type);
        if (!first) return expected(path_, "a value of element " + kind.name, place());
        values_.push_back(*first);
        if (!property.is_list) continue;
        if (!(*first >= 0) || *first > static_cast<double>(bytes_.remaining())) {
            return mesh_error("E-MDL-007", "the file is too short for the length of a list", path_, place());
        }
        const bool indices = property.name == "vertex_indices" || property.name == "vertex_index";
        if (indices) list_.clear();
        for (auto i = static_cast<std::uint64_t>(*first); i > 0; --i) {
            const auto item = value(property.type);
            if (!item) return expected(path_, "a value of element " + kind.name, place());
            if (indices) list_.push_back(*item);
        }
    }
    return Nothing{};
}

// Takes the element that was read into the mesh.
Status PlyReader::keep(const ElementKind& kind) {
    const auto named = [&](std::string_view name) -> std::optional<double> {
        for (std::size_t i = 0; i < kind.properties.size(); ++i) {
            if (kind.properties[i].name == name && !kind.properties[i].is_list) return values_[i];
        }
        return std::nullopt;
    };
    if (kind.name == "vertex") {
        const auto x = named("x"), y = named("y"), z = named("z");
        if (!x || !y || !z) return expected(path_, "vertices with x, y and z", place());
        ANATOMESH_CHECK_STATUS(check_point({*x, *y, *z}, mesh_.points.size(), path_));
        mesh_.points.push_back({*x, *y, *z});
        return Nothing{};
    }
    if (list_.size() < 3) return expected(path_, "a face of at least three vertices", place());
    for (const double index : list_) {
        if (!(index >= 0) || index >= static_cast<double>(mesh_.points.size()) ||
            index != std::floor(index)) {
            return mesh_error("E-MDL-004",
                              "a face names a vertex that does not exist (there are " +
                                  std::to_string(mesh_.points.size()) + ")",
                              path_, place());
        }
    }
    if (list_.size() > 3) ++polygons_;
    const auto inner = named("region_in"), outer = named("region_out");
    for (std::size_t i = 2; i < list_.size(); ++i) {
        mesh_.triangles.push_back({static_cast<std::uint32_t>(list_[0]),
                                   static_cast<std::uint32_t>(list_[i - 1]),
                                   static_cast<std::uint32_t>(list_[i])});
        if (!inner || !outer) continue;
        inner_.push_back(std::abs(*inner) < 1e6 ? static_cast<std::int64_t>(*inner) : -1);
        outer_.push_back(std::abs(*outer) < 1e6 ? static_cast<std::int64_t>(*outer) : -1);
    }
    return Nothing{};
}

Result<SurfaceFile> PlyReader::run(RunContext& context) {
    ANATOMESH_CHECK_STATUS(header());
    for (const ElementKind& kind : kinds_) {
        // Every property takes at least a byte, or a digit and a blank.
        std::size_t least = 0;
        for (const Property& property : kind.properties) {
            least += text_ ? 2 : bytes_of(property.is_list ? property.count_type : property.type);
        }
        if (least == 0 ? kind.count > 0 : kind.count > bytes_.remaining() / least + 1) {
            return mesh_error("E-MDL-007", "the file is too short for the number of elements it states",
                              path_, kind.name + " " + std::to_string(kind.count));
        }
        if (kind.count >= no_cell) return mesh_error("E-MDL-013", "more than 2^32 - 2 elements", path_);
        const bool kept = kind.name == "vertex" || kind.name == "face";
        for (std::uint64_t i = 0; i < kind.count; ++i) {
            list_.clear();
            ANATOMESH_CHECK_STATUS(element(kind));
            if (kept) {
                ANATOMESH_CHECK_STATUS(keep(kind));
            }
        }
    }
    if (mesh_.triangles.empty()) return mesh_error("E-MDL-008", "the file has no triangles", path_);
    warn_polygons(polygons_, path_, context);
    if (reader_.has_regions() && inner_.size() == mesh_.triangles.size()) {
        ANATOMESH_TRY(const std::vector<Region> inner, reader_.regions_of_indices(inner_));
        ANATOMESH_TRY(const std::vector<Region> outer, reader_.regions_of_indices(outer_));
        for (std::size_t i = 0; i < inner.size(); ++i) mesh_.sides.push_back({inner[i], outer[i]});
    }
    return SurfaceFile{std::move(mesh_), reader_.finish(context)};
}

template <class T>
void put(std::string& bytes, T value) {
    static_assert(std::endian::native == std::endian::little);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

Result<std::string> format_ply(const std::string&, const SurfaceFile& surface, RunContext&) {
    const SurfaceMesh& mesh = surface.surface;
    std::string bytes = "ply\nformat binary_little_endian 1.0\n";
    for (const std::string& line : description_lines(surface.description)) bytes += "comment " + line + "\n";
    bytes += "element vertex " + std::to_string(mesh.points.size()) +
             "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
             std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
    if (!mesh.sides.empty()) bytes += "property ushort region_in\nproperty ushort region_out\n";
    bytes += "end_header\n";
    for (const Vec3& point : mesh.points) {
        put(bytes, point.x);
        put(bytes, point.y);
        put(bytes, point.z);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        put(bytes, std::uint8_t{3});
        for (const std::uint32_t vertex : mesh.triangles[t]) put(bytes, static_cast<std::int32_t>(vertex));
        if (mesh.sides.empty()) continue;
        put(bytes, mesh.sides[t][0]);
        put(bytes, mesh.sides[t][1]);
    }
    return bytes;
}

Result<SurfaceFile> parse_ply(const std::string& path, Bytes content, RunContext& context) {
    return PlyReader(path, content).run(context);
}

}  // namespace anatomesh
