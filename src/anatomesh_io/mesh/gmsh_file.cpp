// Gmsh .msh 4.1: written binary; read binary or as text. A volume per region, a physical group per structure.
// Follows: Gmsh reference manual, "MSH file format".
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <map>
#include <set>

#include "anatomesh/geom/box.h"
#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"
#include "anatomesh_io/mesh/quadratic_nodes.h"

namespace anatomesh {

namespace {

// This is the type of a tetrahedron with four nodes. [code; 4; D Gmsh MSH format]
constexpr int gmsh_tetrahedron = 4;
// This is the type of a tetrahedron with ten nodes. [code; 11; D Gmsh MSH format]
constexpr int gmsh_quadratic_tetrahedron = 11;

template <class T>
void append_value(std::string& bytes, T value) {
    static_assert(std::endian::native == std::endian::little);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Gmsh's physical tags are positive: numbers below get the next free ones.
std::vector<std::int32_t> positive_numbers(std::vector<std::int32_t> numbers, const std::string& path,
                                           RunContext& context) {
    std::set<std::int32_t> used(numbers.begin(), numbers.end());
    std::int32_t next = 1;
    for (std::size_t r = 0; r < numbers.size(); ++r) {
        if (numbers[r] > 0) continue;
        while (used.contains(next)) ++next;
        used.insert(next);
        if (r == 0) {  // outside has no number to lose
            numbers[r] = next;
            continue;
        }
        Warning warning{"W-MDL-003",
                        "Gmsh cannot hold structure number " + std::to_string(numbers[r]),
                        {},
                        "it was written as physical group " + std::to_string(next)};
        warning.place.file = path;
        context.warn(std::move(warning));
        numbers[r] = next;
    }
    return numbers;
}

// Within quotes, at most 127 bytes, as Gmsh wants it.
std::string physical_name(std::string name) {
    for (char& c : name) {
        if (c == '"' || static_cast<unsigned char>(c) < 0x20) c = '\'';
    }
    return name.substr(0, 127);
}

// The tag of a region's volume: its own number, which Gmsh wants positive.
std::int32_t volume_of(std::size_t region, std::size_t regions) {
    return static_cast<std::int32_t>(region == 0 ? regions : region);
}

std::string gmsh_region_name(const MeshDescription& description, std::size_t region) {
    if (region == 0) return "outside";
    std::string name;
    for (const std::uint32_t member : description.regions.members[region]) {
        const Structure& structure = description.structures[member];
        if (!name.empty()) name += " + ";
        name += structure.name.empty() ? "structure " + std::to_string(structure.number) : structure.name;
    }
    return physical_name(name);
}

void append_entities(std::string& bytes, const TetMesh& mesh, const std::vector<std::size_t>& used,
                     const std::vector<std::int32_t>& numbers) {
    std::vector<Box3> boxes(numbers.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        for (const std::uint32_t vertex : mesh.cells[c]) boxes[mesh.regions[c]].extend(mesh.points[vertex]);
    }
    bytes += "$Entities\n";
    for (const std::size_t count : {std::size_t{0}, std::size_t{0}, std::size_t{0}, used.size()}) {
        append_value(bytes, static_cast<std::uint64_t>(count));
    }
    for (const std::size_t region : used) {
        append_value(bytes, volume_of(region, numbers.size()));
        for (const Vec3& corner : {boxes[region].low, boxes[region].high}) {
            append_value(bytes, corner.x);
            append_value(bytes, corner.y);
            append_value(bytes, corner.z);
        }
        append_value(bytes, std::uint64_t{1});  // physical groups
        append_value(bytes, numbers[region]);
        append_value(bytes, std::uint64_t{0});  // bounding surfaces
    }
    bytes += "\n$EndEntities\n";
}

void append_points(std::string& bytes, const std::vector<Vec3>& points) {
    bytes.append(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Vec3));
}

void append_gmsh_nodes(std::string& bytes, const ModelFile& model, std::int32_t volume) {
    const auto n = static_cast<std::uint64_t>(node_count(model));
    bytes += "$Nodes\n";
    for (const std::uint64_t value : {std::uint64_t{1}, n, std::uint64_t{1}, n}) append_value(bytes, value);
    append_value(bytes, std::int32_t{3});  // all in one block, on the first volume
    append_value(bytes, volume);
    append_value(bytes, std::int32_t{0});
    append_value(bytes, n);
    for (std::uint64_t i = 1; i <= n; ++i) append_value(bytes, i);
    append_points(bytes, model.mesh.points);
    append_points(bytes, model.mid_nodes.points);
    bytes += "\n$EndNodes\n";
}

// The cells in the order of the file: by region.
std::vector<std::vector<std::uint32_t>> cells_by_region(const TetMesh& mesh, std::size_t regions) {
    std::vector<std::vector<std::uint32_t>> cells_of(regions);
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) cells_of[mesh.regions[c]].push_back(c);
    return cells_of;
}

void append_gmsh_elements(std::string& bytes, const ModelFile& model, const std::vector<std::size_t>& used,
                          std::size_t regions) {
    const auto cells_of = cells_by_region(model.mesh, used.back() + 1);
    const auto n = static_cast<std::uint64_t>(model.mesh.cells.size());
    bytes += "$Elements\n";
    for (const std::uint64_t value : {static_cast<std::uint64_t>(used.size()), n, std::uint64_t{1}, n}) {
        append_value(bytes, value);
    }
    for (const std::size_t region : used) {
        append_value(bytes, std::int32_t{3});
        append_value(bytes, volume_of(region, regions));
        append_value(bytes,
                     std::int32_t{model.mid_nodes.empty() ? gmsh_tetrahedron : gmsh_quadratic_tetrahedron});
        append_value(bytes, static_cast<std::uint64_t>(cells_of[region].size()));
        for (const std::uint32_t c : cells_of[region]) {
            append_value(bytes, std::uint64_t{c} + 1);
            each_node(model, c, gmsh_edge_order, [&](std::uint64_t node) { append_value(bytes, node + 1); });
        }
    }
    bytes += "\n$EndElements\n";
}

// A value per element, in the order of the elements in the file.
template <class Value>
void append_element_data(std::string& bytes, const char* name, const ModelFile& model,
                         const std::vector<std::size_t>& used, const Value& value) {
    bytes += std::string("$ElementData\n1\n\"") + name + "\"\n1\n0\n3\n0\n1\n" +
             std::to_string(model.mesh.cells.size()) + "\n";
    const auto cells_of = cells_by_region(model.mesh, used.back() + 1);
    for (const std::size_t region : used) {
        for (const std::uint32_t c : cells_of[region]) {
            append_value(bytes, static_cast<std::int32_t>(c + 1));
            append_value(bytes, static_cast<double>(value(c)));
        }
    }
    bytes += "\n$EndElementData\n";
}

}  // namespace

Result<std::string> format_gmsh(const std::string& path, const ModelFile& model, RunContext& context) {
    const TetMesh& mesh = model.mesh;
    const std::vector<std::int32_t> numbers =
        positive_numbers(region_numbers(model.description), path, context);
    std::vector<bool> occurs(numbers.size(), false);
    for (const Region region : mesh.regions) occurs[region] = true;
    std::vector<std::size_t> used;
    for (std::size_t r = 0; r < occurs.size(); ++r) {
        if (occurs[r]) used.push_back(r);
    }
    if (used.empty()) return mesh_error("E-MDL-008", "the model has no tetrahedra", path);

    std::string bytes = "$MeshFormat\n4.1 1 8\n";
    bytes.reserve(mesh.points.size() * 32 + mesh.cells.size() * 40 + 10'000);
    append_value(bytes, std::int32_t{1});
    bytes += "\n$EndMeshFormat\n$Comments\n";
    for (const std::string& line : description_lines(model.description)) bytes += line + "\n";
    bytes += "$EndComments\n$PhysicalNames\n" + std::to_string(used.size()) + "\n";
    for (const std::size_t region : used) {
        bytes += "3 " + std::to_string(numbers[region]) + " \"" +
                 gmsh_region_name(model.description, region) + "\"\n";
    }
    bytes += "$EndPhysicalNames\n";
    append_entities(bytes, mesh, used, numbers);
    append_gmsh_nodes(bytes, model, volume_of(used.front(), numbers.size()));
    append_gmsh_elements(bytes, model, used, numbers.size());
    if (!model.grey.empty()) {
        append_element_data(bytes, "grey", model, used, [&](std::uint32_t c) { return model.grey[c]; });
    }
    if (!model.material.empty()) {
        append_element_data(bytes, "material", model, used,
                            [&](std::uint32_t c) { return model.material[c] + 1; });
    }
    return bytes;
}

namespace {

// The values of a section, binary or as words of text. After a failed read() every later one fails as well.
class GmshValues {
  public:
    explicit GmshValues(Bytes content) : reader_(content) {}

    bool binary = false;
    void set_order(std::endian order) { reader_.set_order(order); }
    bool good() const { return good_; }
    std::string place() const { return "byte " + std::to_string(reader_.position()); }
    std::optional<std::string_view> line() { return reader_.read_line(); }

    template <class T>
    T read() {
        std::optional<T> value = binary ? reader_.read<T>() : number_of<T>(word());
        good_ = good_ && value.has_value();
        return good_ ? *value : T{};
    }
    // A count of things of at least `bytes_each` bytes in binary, or `words_each` words of text: never more
    // than what follows can hold.
    std::optional<std::uint64_t> count(std::size_t bytes_each, std::size_t words_each) {
        const auto value = read<std::uint64_t>();
        const std::size_t each = std::max<std::size_t>(binary ? bytes_each : 2 * words_each, 1);
        if (!good_ || value > reader_.remaining() / each + 1) return std::nullopt;
        return value;
    }
    void skip_words(std::uint64_t count) {
        for (std::uint64_t i = 0; i < count && good_; ++i) good_ = !word().empty();
    }
    // Skips to behind the line "$End<name>".
    bool skip_section(std::string_view name) {
        const std::string end = "$End" + std::string(name);
        const std::size_t begin = reader_.position();
        const std::string_view rest = reader_.read_text(reader_.remaining()).value_or("");
        const std::size_t found = rest.find(end);
        if (found == std::string_view::npos) return false;
        reader_.seek(begin + found + end.size());
        return true;
    }

  private:
    std::string_view word() {
        const auto blank = [](char c) { return is_blank(c) || c == '\n'; };
        const std::size_t begin = reader_.position();
        const std::string_view rest = reader_.read_text(reader_.remaining()).value_or("");
        std::size_t first = 0;
        while (first < rest.size() && blank(rest[first])) ++first;
        std::size_t last = first;
        while (last < rest.size() && !blank(rest[last])) ++last;
        reader_.seek(begin + last);
        return rest.substr(first, last - first);
    }

    ByteReader reader_;
    bool good_ = true;
};

struct GmshElement {
    std::uint64_t tag = 0;
    std::size_t first_node = 0;  // of its 4 or 10 in element_nodes_
    std::int32_t volume = 0;
};

// Nodes of an element type of dimension 0 to 2 (Gmsh's numbering); 0 for others.
std::size_t nodes_of_lower_type(std::int32_t type) {
    switch (type) {
        case 15:
            return 1;
        case 1:
            return 2;
        case 2:
        case 8:
            return 3;
        case 3:
            return 4;
        case 9:
            return 6;
        case 10:
            return 9;
        case 16:
            return 8;
        default:
            return 0;
    }
}

class GmshReader {
  public:
    GmshReader(const std::string& path, Bytes content) : path_(path), reader_(path), values_(content) {}
    Result<ModelFile> run(RunContext& context);

  private:
    Status format();
    Status comments();
    Status physical_names();
    Status entities();
    Status nodes();
    Status elements();
    Status element_block(std::uint64_t& left);
    Status element_data();
    Status place_nodes();
    Status place_elements();
    Status place_regions();
    Status place_values();
    Result<std::uint32_t> vertex_of(std::uint64_t tag, const GmshElement& element) const;

    Error broken(const char* what) const { return expected(path_, what, values_.place()); }
    Error too_many() const {
        return mesh_error("E-MDL-007", "the file is too short for the number of elements it states", path_,
                          values_.place());
    }

    const std::string& path_;
    DescriptionReader reader_;
    GmshValues values_;
    std::map<std::int32_t, std::int32_t> group_of_volume_;  // its first physical group
    std::map<std::int32_t, std::string> name_of_group_;
    std::vector<std::pair<std::uint64_t, Vec3>> nodes_;
    std::vector<GmshElement> elements_;
    std::vector<std::uint64_t> element_nodes_;
    std::size_t nodes_each_ = 0;                                     // of a tetrahedron: 4 or 10
    std::vector<std::pair<std::uint64_t, double>> grey_, material_;  // by element tag
    std::size_t left_out_ = 0;
    ModelFile model_;
};

Status GmshReader::format() {
    std::string_view line = values_.line().value_or("");
    const auto version = take_word(line);
    const auto mode = take_number<int>(line), size = take_number<int>(line);
    if (version != "4.1") {
        Error error = mesh_error("E-MDL-012", "the program reads version 4.1 of the format only", path_,
                                 std::string(version.substr(0, 20)));
        error.next_step = "save it again in version 4.1 (gmsh -save -format msh41)";
        return error;
    }
    if (!mode || !size || *mode < 0 || *mode > 1 || *size != 8) {
        return mesh_error("E-MDL-012", "the file is neither text nor binary with 8 bytes per size", path_,
                          values_.place());
    }
    if (*mode == 1) {
        values_.binary = true;
        values_.set_order(std::endian::little);
        const auto one = values_.read<std::int32_t>();
        if (one == 0x01000000) {
            values_.set_order(std::endian::big);
        } else if (one != 1) {
            return broken("the number 1 that shows the byte order");
        }
    }
    return Nothing{};
}

Status GmshReader::comments() {
    while (const auto line = values_.line()) {
        if (*line == "$EndComments") return Nothing{};
        ANATOMESH_CHECK_STATUS(reader_.take(*line));
    }
    return broken("$EndComments");
}

Status GmshReader::physical_names() {
    while (const auto line = values_.line()) {
        if (*line == "$EndPhysicalNames") return Nothing{};
        std::string_view rest = *line;
        const auto dimension = take_number<int>(rest);
        const auto tag = take_number<std::int32_t>(rest);
        rest = trimmed(rest);
        if (dimension == 3 && tag && rest.size() >= 2 && rest.front() == '"' && rest.back() == '"') {
            name_of_group_[*tag] = std::string(rest.substr(1, rest.size() - 2));
        }
    }
    return broken("$EndPhysicalNames");
}

Status GmshReader::entities() {
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& count : counts) {
        const auto value = values_.count(40, 6);
        if (!value) return too_many();
        count = *value;
    }
    for (std::size_t dimension = 0; dimension < 4; ++dimension) {
        for (std::uint64_t i = 0; i < counts[dimension]; ++i) {
            const auto tag = values_.read<std::int32_t>();
            // A point has one corner, the others two.
            for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) values_.read<double>();
            const auto groups = values_.count(4, 1);
            if (!groups) return too_many();
            for (std::uint64_t g = 0; g < *groups; ++g) {
                const auto group = values_.read<std::int32_t>();
                if (dimension == 3) group_of_volume_.emplace(tag, group);
            }
            const auto boundary = dimension == 0 ? 0 : values_.count(4, 1);
            if (!boundary) return too_many();
            for (std::uint64_t b = 0; b < *boundary; ++b) values_.read<std::int32_t>();
            if (!values_.good()) return broken("an entity");
        }
    }
    return Nothing{};
}

Status GmshReader::nodes() {
    const auto blocks = values_.count(20, 4), total = values_.count(32, 4);
    values_.read<std::uint64_t>();
    values_.read<std::uint64_t>();
    if (!blocks || !total) return too_many();
    nodes_.reserve(*total);
    for (std::uint64_t b = 0; b < *blocks; ++b) {
        const auto dimension = values_.read<std::int32_t>();
        values_.read<std::int32_t>();
        const bool parametric = values_.read<std::int32_t>() != 0;
        const auto count = values_.count(32, 4);
        if (!values_.good()) return broken("a block of nodes");
        if (!count || nodes_.size() + *count > *total) return too_many();
        const std::size_t first = nodes_.size();
        for (std::uint64_t i = 0; i < *count; ++i) nodes_.emplace_back(values_.read<std::uint64_t>(), Vec3{});
        for (std::size_t i = first; i < nodes_.size(); ++i) {
            Vec3& point = nodes_[i].second;
            for (double* coordinate : {&point.x, &point.y, &point.z}) *coordinate = values_.read<double>();
            for (int k = 0; parametric && k < std::min(dimension, 3); ++k) values_.read<double>();
            if (!values_.good()) return broken("a node");
            ANATOMESH_CHECK_STATUS(check_point(point, nodes_[i].first, path_));
        }
    }
    return Nothing{};
}

Status GmshReader::elements() {
    const auto blocks = values_.count(20, 4), total = values_.count(16, 2);
    values_.read<std::uint64_t>();
    values_.read<std::uint64_t>();
    if (!blocks || !total) return too_many();
    std::uint64_t left = *total;
    for (std::uint64_t b = 0; b < *blocks; ++b) {
        ANATOMESH_CHECK_STATUS(element_block(left));
    }
    return Nothing{};
}

Status GmshReader::element_block(std::uint64_t& left) {
    const auto dimension = values_.read<std::int32_t>();
    const auto entity = values_.read<std::int32_t>();
    const auto type = values_.read<std::int32_t>();
    const auto count = values_.count(16, 2);
    if (!values_.good()) return broken("a block of elements");
    if (!count || *count > left) return too_many();
    left -= *count;
    const std::size_t lower = nodes_of_lower_type(type);
    const std::size_t nodes = type == gmsh_tetrahedron ? 4 : type == gmsh_quadratic_tetrahedron ? 10 : 0;
    if (nodes == 0 && (dimension > 2 || lower == 0)) {
        Error error = mesh_error(
            "E-MDL-006",
            "the program reads tetrahedra of four or ten nodes only, not Gmsh type " + std::to_string(type),
            path_, values_.place());
        error.next_step = "turn the elements into tetrahedra first";
        return error;
    }
    if (nodes > 0 && nodes_each_ > 0 && nodes != nodes_each_) return mixed_orders(path_, values_.place());
    if (nodes > 0) nodes_each_ = nodes;
    for (std::uint64_t i = 0; i < *count; ++i) {
        GmshElement element;
        element.volume = entity;
        element.tag = values_.read<std::uint64_t>();
        if (nodes > 0) {
            element.first_node = element_nodes_.size();
            for (std::size_t k = 0; k < nodes; ++k) element_nodes_.push_back(values_.read<std::uint64_t>());
            elements_.push_back(element);
        } else {
            for (std::size_t k = 0; k < lower; ++k) values_.read<std::uint64_t>();
            ++left_out_;
        }
        if (!values_.good()) return broken("an element");
    }
    return Nothing{};
}

// Nodes and elements by increasing tag: the order of vertices and cells.
Status GmshReader::place_nodes() {
    const auto by_tag = [](const auto& a, const auto& b) { return a.first < b.first; };
    if (!std::is_sorted(nodes_.begin(), nodes_.end(), by_tag))
        std::stable_sort(nodes_.begin(), nodes_.end(), by_tag);
    if (nodes_.size() >= no_cell) return mesh_error("E-MDL-013", "more than 2^32 - 2 nodes", path_);
    model_.mesh.points.reserve(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (i > 0 && nodes_[i - 1].first == nodes_[i].first) {
            return mesh_error("E-MDL-009", "two nodes have the same tag", path_,
                              std::to_string(nodes_[i].first));
        }
        model_.mesh.points.push_back(nodes_[i].second);
    }
    return Nothing{};
}

Result<std::uint32_t> GmshReader::vertex_of(std::uint64_t tag, const GmshElement& element) const {
    const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), tag,
                                        [](const auto& node, std::uint64_t t) { return node.first < t; });
    if (found == nodes_.end() || found->first != tag) {
        return mesh_error("E-MDL-004",
                          "an element names node " + std::to_string(tag) + ", which is not there", path_,
                          "element " + std::to_string(element.tag));
    }
    return static_cast<std::uint32_t>(found - nodes_.begin());
}

Status GmshReader::place_elements() {
    std::stable_sort(elements_.begin(), elements_.end(),
                     [](const GmshElement& a, const GmshElement& b) { return a.tag < b.tag; });
    model_.mesh.cells.reserve(elements_.size());
    std::vector<std::array<std::uint32_t, 6>> mid_nodes;
    for (std::size_t e = 0; e < elements_.size(); ++e) {
        const GmshElement& element = elements_[e];
        if (e > 0 && elements_[e - 1].tag == element.tag) {
            return mesh_error("E-MDL-009", "two elements have the same tag", path_,
                              std::to_string(element.tag));
        }
        const std::uint64_t* nodes = element_nodes_.data() + element.first_node;
        Cell cell;
        for (std::size_t i = 0; i < 4; ++i) {
            ANATOMESH_TRY(cell[i], vertex_of(nodes[i], element));
        }
        model_.mesh.cells.push_back(cell);
        if (nodes_each_ == 4) continue;
        std::array<std::uint32_t, 6> six;
        for (std::size_t i = 0; i < 6; ++i) {
            ANATOMESH_TRY(six[gmsh_edge_order[i]], vertex_of(nodes[4 + i], element));
        }
        mid_nodes.push_back(six);
    }
    return mid_nodes.empty() ? Status(Nothing{}) : split_mid_nodes(model_, std::move(mid_nodes), path_);
}

// A view of one value per element; those of other names or shapes are passed over.
Status GmshReader::element_data() {
    const auto tags = [&](std::vector<std::string>& lines) {
        const auto count = number_of<std::size_t>(trimmed(values_.line().value_or("")));
        for (std::size_t i = 0; count && i < std::min<std::size_t>(*count, 100); ++i) {
            lines.emplace_back(trimmed(values_.line().value_or("")));
        }
    };
    std::vector<std::string> names, reals, integers;
    tags(names);
    tags(reals);
    tags(integers);
    const std::uint64_t count = integers.size() > 2 ? number_of<std::uint64_t>(integers[2]).value_or(0) : 0;
    auto* target = names.empty()                ? nullptr
                   : names[0] == "\"grey\""     ? &grey_
                   : names[0] == "\"material\"" ? &material_
                                                : nullptr;
    if (target && count > 0 && integers[1] == "1") {
        for (std::uint64_t i = 0; i < count; ++i) {
            const auto tag = values_.read<std::int32_t>();
            const auto value = values_.read<double>();
            if (!values_.good()) return broken("a value of an element");
            target->emplace_back(static_cast<std::uint64_t>(tag), value);
        }
    }
    return values_.skip_section("ElementData") ? Status(Nothing{}) : broken("$EndElementData");
}

// Values of every element, or of none.
Status GmshReader::place_values() {
    for (auto* values : {&grey_, &material_}) {
        std::sort(values->begin(), values->end());
        const bool all = values->size() == elements_.size() &&
                         std::equal(values->begin(), values->end(), elements_.begin(),
                                    [](const auto& value, const GmshElement& element) {
                                        return value.first == element.tag;
                                    });
        if (!all) values->clear();
    }
    for (const auto& value : grey_) model_.grey.push_back(value.second);
    if (!reader_.has_materials()) return Nothing{};
    std::vector<std::int64_t> numbers;
    for (const auto& value : material_) {
        const bool whole = value.second >= 0 && value.second < 1e9;
        numbers.push_back(whole ? static_cast<std::int64_t>(value.second) : 0);
    }
    ANATOMESH_TRY(model_.material, reader_.materials_of_numbers(numbers));
    return Nothing{};
}

// With our table a volume is a region; else a structure is a physical group, or a volume without one.
Status GmshReader::place_regions() {
    std::vector<std::int64_t> labels;
    labels.reserve(elements_.size());
    for (const GmshElement& element : elements_) {
        const auto group = group_of_volume_.find(element.volume);
        const bool by_volume = reader_.has_regions() || group == group_of_volume_.end();
        labels.push_back(by_volume ? element.volume : group->second);
    }
    if (reader_.has_regions()) {
        const auto outside = volume_of(0, reader_.regions());
        std::replace(labels.begin(), labels.end(), std::int64_t{outside}, std::int64_t{0});
        ANATOMESH_TRY(model_.mesh.regions, reader_.regions_of_indices(labels));
    } else {
        ANATOMESH_TRY(model_.mesh.regions, reader_.regions_of_labels(labels, labels.size()));
    }
    return Nothing{};
}

Result<ModelFile> GmshReader::run(RunContext& context) {
    bool has_format = false;
    while (const auto raw = values_.line()) {
        const std::string name(trimmed(*raw));
        if (name.empty() || name.front() != '$' || name.starts_with("$End")) continue;
        if (!has_format && name != "$MeshFormat" && name != "$Comments") return broken("$MeshFormat");
        if (name == "$MeshFormat") {
            has_format = true;
            ANATOMESH_CHECK_STATUS(format());
        } else if (name == "$Comments") {
            ANATOMESH_CHECK_STATUS(comments());
        } else if (name == "$PhysicalNames") {
            ANATOMESH_CHECK_STATUS(physical_names());
        } else if (name == "$Entities") {
            ANATOMESH_CHECK_STATUS(entities());
        } else if (name == "$Nodes") {
            ANATOMESH_CHECK_STATUS(nodes());
        } else if (name == "$Elements") {
            ANATOMESH_CHECK_STATUS(elements());
        } else if (name == "$ElementData") {
            ANATOMESH_CHECK_STATUS(element_data());
        } else if (!values_.skip_section(name.substr(1))) {
            return broken(("the end of section " + name.substr(0, 40)).c_str());
        }
    }
    if (elements_.empty()) return mesh_error("E-MDL-008", "the file has no tetrahedra", path_);
    warn_left_out(left_out_, "tetrahedra", path_, context);
    ANATOMESH_CHECK_STATUS(place_nodes());
    ANATOMESH_CHECK_STATUS(place_elements());
    const bool foreign = !reader_.has_regions();
    ANATOMESH_CHECK_STATUS(place_regions());
    ANATOMESH_CHECK_STATUS(place_values());
    model_.description = reader_.finish(context);
    if (foreign) {
        for (Structure& structure : model_.description.structures) {
            const auto name = name_of_group_.find(structure.number);
            if (name != name_of_group_.end()) structure.name = name->second;
        }
    }
    return std::move(model_);
}

}  // namespace

Result<ModelFile> parse_gmsh(const std::string& path, Bytes content, RunContext& context) {
    return GmshReader(path, content).run(context);
}

}  // namespace anatomesh
