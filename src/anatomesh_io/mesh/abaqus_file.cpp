// Abaqus .inp: nodes, C3D4 or C3D10 elements by region, sets of elements, nodes and facets per structure and
// per interface, materials. Follows: Abaqus Keywords Reference Guide (*NODE, *ELEMENT, *ELSET, *NSET,
// *SURFACE, *MATERIAL, *SOLID SECTION).
#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"
#include "anatomesh_io/mesh/model_sets.h"
#include "anatomesh_io/mesh/quadratic_nodes.h"

namespace anatomesh {

namespace {

// Face of an element opposite vertex i: S1 is 1-2-3, S2 is 1-4-2, S3 is 2-4-3, S4 is 3-4-1.
constexpr std::array<const char*, 4> face_opposite{"S3", "S4", "S2", "S1"};

constexpr std::string_view region_set = "REGION_", material_set = "MATERIAL_";

std::string region_name(std::size_t region) {
    return std::string(region_set) + std::to_string(region);
}

// In fixed notation: CalculiX reads 20 characters of a number, and would cut an exponent off.
void append_coordinate(std::string& text, double value) {
    std::array<char, 400> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed);
    text.append(buffer.data(), end.ptr);
}

void append_nodes(std::string& text, const ModelFile& model) {
    text += "*NODE, NSET=ALL\n";
    for (std::size_t n = 0; n < node_count(model); ++n) {
        const Vec3& point = node_at(model, n);
        append_number(text, n + 1);
        for (const double coordinate : {point.x, point.y, point.z}) {
            text += ", ";
            append_coordinate(text, coordinate);
        }
        text += '\n';
    }
}

void append_elements(std::string& text, const ModelFile& model) {
    const char* type = model.mid_nodes.empty() ? "C3D4" : "C3D10";
    std::vector<std::vector<std::uint32_t>> cells_of(model.description.regions.members.size());
    for (std::uint32_t c = 0; c < model.mesh.cells.size(); ++c) cells_of[model.mesh.regions[c]].push_back(c);
    for (std::size_t r = 0; r < cells_of.size(); ++r) {
        if (cells_of[r].empty()) continue;
        text += std::string("*ELEMENT, TYPE=") + type + ", ELSET=" + region_name(r) + "\n";
        for (const std::uint32_t c : cells_of[r]) {
            append_number(text, std::uint64_t{c} + 1);
            each_node(model, c, vtk_edge_order, [&](std::uint64_t node) {
                text += ", ";
                append_number(text, node + 1);
            });
            text += '\n';
        }
    }
}

// Numbers from 0, written from 1, sixteen a line.
template <class Number>
void append_set(std::string& text, const std::string& keyword, const std::vector<Number>& numbers) {
    if (numbers.empty()) return;
    // A data line of a set has no more entries. [entries; 16; D Abaqus input format]
    constexpr std::size_t most_in_line = 16;
    text += keyword + "\n";
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (i > 0) text += i % most_in_line == 0 ? ",\n" : ", ";
        append_number(text, std::uint64_t{numbers[i]} + 1);
    }
    text += '\n';
}

void append_surface(std::string& text, const std::string& name, std::span<const std::uint64_t> facets) {
    if (facets.empty()) return;
    text += "*SURFACE, TYPE=ELEMENT, NAME=" + name + "\n";
    for (const std::uint64_t facet : facets) {
        append_number(text, facet / 4 + 1);
        text += ", ";
        text += face_opposite[facet % 4];
        text += '\n';
    }
}

// A structure is the union of its regions: a set of sets; its nodes; its boundary.
void append_structure(std::string& text, const ModelFile& model, std::uint32_t structure,
                      const std::vector<bool>& used, std::span<const InterfaceFacet> facets) {
    std::string members;
    for (std::size_t r = 1; r < used.size(); ++r) {
        if (used[r] && model.description.regions.contains(static_cast<Region>(r), structure)) {
            members += region_name(r) + "\n";
        }
    }
    if (members.empty()) return;
    const std::string name = structure_set_name(model.description.structures[structure].number);
    text += "*ELSET, ELSET=" + name + "\n" + members;
    append_set(text, "*NSET, NSET=NODES_" + name, structure_nodes(model, structure));
    append_surface(text, "SURFACE_" + name, structure_facets(facets, model.description.regions, structure));
}

// Its surface, seen from the inner region; elements on both sides; nodes.
void append_interface(std::string& text, const ModelFile& model, const Interface& interface) {
    std::vector<std::uint64_t> inner, both;
    for (const InterfaceFacet& facet : interface.facets) {
        inner.push_back(facet.facet);
        both.push_back(facet.facet);
        if (facet.other != no_facet) both.push_back(facet.other);
    }
    append_set(text, "*ELSET, ELSET=ELEMENTS_" + interface.name(), cells_of_facets(both));
    append_set(text, "*NSET, NSET=NODES_" + interface.name(), facet_nodes(model, inner));
    append_surface(text, interface.name(), inner);
}

void append_materials(std::string& text, const ModelFile& model) {
    if (model.material.empty()) return;
    const std::vector<Material>& materials = model.description.materials;
    std::vector<std::vector<std::uint32_t>> cells_of(materials.size());
    for (std::uint32_t c = 0; c < model.material.size(); ++c) cells_of[model.material[c]].push_back(c);
    for (std::size_t m = 0; m < materials.size(); ++m) {
        if (cells_of[m].empty()) continue;
        const std::string name = std::string(material_set) + std::to_string(m + 1);
        append_set(text, "*ELSET, ELSET=" + name, cells_of[m]);
        text += "*MATERIAL, NAME=" + name + "\n*ELASTIC\n";
        append_number(text, materials[m].young_mpa);
        text += ", ";
        append_number(text, materials[m].poisson);
        if (materials[m].density_t_mm3 > 0) {
            text += "\n*DENSITY\n";
            append_number(text, materials[m].density_t_mm3);
        }
        text += "\n*SOLID SECTION, ELSET=" + name + ", MATERIAL=" + name + "\n";
    }
}

}  // namespace

Result<std::string> format_abaqus(const std::string& path, const ModelFile& model, RunContext& context) {
    if (!model.grey.empty() && model.material.empty()) warn_cell_values("grey values", path, context);
    std::string text = "*HEADING\nanatomesh model, SPACE=" + model.description.space +
                       " UNIT=" + model.description.unit + "\n";
    for (const std::string& line : description_lines(model.description)) text += "** " + line + "\n";
    append_nodes(text, model);
    append_elements(text, model);
    const std::vector<bool> used = used_regions(model);
    const std::vector<InterfaceFacet> facets = interface_facets(model.mesh);
    for (std::uint32_t s = 0; s < model.description.structures.size(); ++s) {
        append_structure(text, model, s, used, facets);
    }
    for (const Interface& interface : interfaces(facets)) append_interface(text, model, interface);
    append_materials(text, model);
    return text;
}

namespace {

// "NAME" of "NAME=value" among the options of a keyword line, in lower case; empty when it is not there.
std::string option(std::string_view line, std::string_view name) {
    while (!line.empty()) {
        const std::size_t comma = std::min(line.find(','), line.size());
        const std::string_view part = line.substr(0, comma);
        line.remove_prefix(std::min(comma + 1, line.size()));
        const std::size_t equals = part.find('=');
        if (equals != std::string_view::npos && lower_case(trimmed(part.substr(0, equals))) == name) {
            return std::string(trimmed(part.substr(equals + 1)));
        }
    }
    return {};
}

std::string_view take_field(std::string_view& line) {
    const std::size_t comma = std::min(line.find(','), line.size());
    const std::string_view field = trimmed(line.substr(0, comma));
    line.remove_prefix(std::min(comma + 1, line.size()));
    return field;
}

struct Element {
    std::uint64_t number = 0;
    std::size_t first_node = 0;  // of its 4 or 10 in element_nodes_
    std::uint32_t set = 0;       // index of its ELSET
};

class AbaqusReader {
  public:
    AbaqusReader(const std::string& path, std::string_view text) : path_(path), reader_(path), lines_(text) {}
    Result<ModelFile> run(RunContext& context);

  private:
    enum class Section : std::uint8_t { other, nodes, tetrahedra, material_members, left_out };

    Status keyword(std::string_view line);
    Status node(std::string_view line);
    Status element(std::string_view line);
    Status material_member(std::string_view line);
    Status unfinished_element() const;
    Status place_nodes();
    Status place_elements();
    Status place_regions();
    Status place_materials();
    Result<std::uint32_t> vertex_of(std::uint64_t number, const Element& element) const;
    Error duplicate(const char* what, std::uint64_t number) const {
        return mesh_error("E-MDL-009", std::string("two ") + what + " have the same number", path_,
                          std::to_string(number));
    }

    const std::string& path_;
    DescriptionReader reader_;
    Lines lines_;
    Section section_ = Section::other;
    std::uint32_t set_ = 0;
    std::vector<std::string> sets_;  // in the order in which they occur
    std::vector<std::pair<std::uint64_t, Vec3>> nodes_;
    std::vector<Element> elements_;
    std::vector<std::uint64_t> element_nodes_;
    std::size_t nodes_each_ = 0;  // of an element: 4 or 10
    std::int64_t material_ = 0;   // whose set this section is
    std::vector<std::pair<std::uint64_t, std::int64_t>> material_of_element_;
    std::size_t left_out_ = 0;
    ModelFile model_;
};

Status AbaqusReader::keyword(std::string_view line) {
    ANATOMESH_CHECK_STATUS(unfinished_element());
    std::string_view rest = line;
    const std::string name = lower_case(take_field(rest));
    section_ = Section::other;
    if (name == "*node") {
        section_ = Section::nodes;
    } else if (name == "*element") {
        const std::string type = lower_case(option(rest, "type"));
        const bool quadratic = type.starts_with("c3d10");
        if (type == "c3d4" || quadratic) {
            section_ = Section::tetrahedra;
            const std::size_t nodes = quadratic ? 10 : 4;
            if (nodes_each_ != 0 && nodes_each_ != nodes) return mixed_orders(path_, lines_.place());
            nodes_each_ = nodes;
            const std::string set = option(rest, "elset");
            const auto known = std::find(sets_.begin(), sets_.end(), set);
            set_ = static_cast<std::uint32_t>(known - sets_.begin());
            if (known == sets_.end()) sets_.push_back(set);
        } else if (type.starts_with("c3d") || type.starts_with("dc3d")) {
            return mesh_error("E-MDL-006",
                              "the program reads tetrahedra (C3D4, C3D10) only, not " + type.substr(0, 20),
                              path_, lines_.place());
        } else {
            section_ = Section::left_out;
        }
    } else if (name == "*elset") {
        const std::string set = option(rest, "elset");
        if (!set.starts_with(material_set) || !reader_.has_materials()) return Nothing{};
        const auto number = number_of<std::int64_t>(std::string_view(set).substr(material_set.size()));
        if (!number) return Nothing{};
        section_ = Section::material_members;
        material_ = *number;
    }
    return Nothing{};
}

Status AbaqusReader::node(std::string_view line) {
    const auto number = number_of<std::uint64_t>(take_field(line));
    if (!number) return expected(path_, "the number of a node", lines_.place());
    Vec3 point;
    for (double* coordinate : {&point.x, &point.y, &point.z}) {
        const auto value = number_of<double>(take_field(line));
        if (!value) return expected(path_, "a coordinate", lines_.place());
        *coordinate = *value;
    }
    ANATOMESH_CHECK_STATUS(check_point(point, *number, path_));
    nodes_.emplace_back(*number, point);
    return Nothing{};
}

// An element may go on over several lines: a comma ends those before the last.
Status AbaqusReader::element(std::string_view line) {
    const bool comma_at_end = trimmed(line).ends_with(',');
    const bool goes_on =
        !elements_.empty() && element_nodes_.size() < elements_.back().first_node + nodes_each_;
    if (!goes_on) {
        const auto number = number_of<std::uint64_t>(take_field(line));
        if (!number) return expected(path_, "the number of an element", lines_.place());
        elements_.push_back({*number, element_nodes_.size(), set_});
    }
    while (!trimmed(line).empty() && element_nodes_.size() < elements_.back().first_node + nodes_each_) {
        const auto node = number_of<std::uint64_t>(take_field(line));
        if (!node) return expected(path_, "the number of a node", lines_.place());
        element_nodes_.push_back(*node);
    }
    return comma_at_end ? Status(Nothing{}) : unfinished_element();
}

Status AbaqusReader::unfinished_element() const {
    if (elements_.empty() || element_nodes_.size() == elements_.back().first_node + nodes_each_)
        return Nothing{};
    return expected(
        path_, std::to_string(nodes_each_) + " nodes of element " + std::to_string(elements_.back().number),
        lines_.place());
}

Status AbaqusReader::material_member(std::string_view line) {
    while (!trimmed(line).empty()) {
        const auto element = number_of<std::uint64_t>(take_field(line));
        if (!element) return expected(path_, "the number of an element", lines_.place());
        material_of_element_.emplace_back(*element, material_);
    }
    return Nothing{};
}

// Nodes by increasing number: the order of the vertices.
Status AbaqusReader::place_nodes() {
    const auto by_number = [](const auto& a, const auto& b) { return a.first < b.first; };
    if (!std::is_sorted(nodes_.begin(), nodes_.end(), by_number)) {
        std::stable_sort(nodes_.begin(), nodes_.end(), by_number);
    }
    if (nodes_.size() >= no_cell) return mesh_error("E-MDL-013", "more than 2^32 - 2 nodes", path_);
    model_.mesh.points.reserve(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (i > 0 && nodes_[i - 1].first == nodes_[i].first) return duplicate("nodes", nodes_[i].first);
        model_.mesh.points.push_back(nodes_[i].second);
    }
    return Nothing{};
}

Result<std::uint32_t> AbaqusReader::vertex_of(std::uint64_t number, const Element& element) const {
    const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), number,
                                        [](const auto& node, std::uint64_t n) { return node.first < n; });
    if (found == nodes_.end() || found->first != number) {
        return mesh_error("E-MDL-004",
                          "an element names node " + std::to_string(number) + ", which is not there", path_,
                          "element " + std::to_string(element.number));
    }
    return static_cast<std::uint32_t>(found - nodes_.begin());
}

Status AbaqusReader::place_elements() {
    std::stable_sort(elements_.begin(), elements_.end(),
                     [](const Element& a, const Element& b) { return a.number < b.number; });
    model_.mesh.cells.reserve(elements_.size());
    std::vector<std::array<std::uint32_t, 6>> mid_nodes;
    for (std::size_t e = 0; e < elements_.size(); ++e) {
        const Element& element = elements_[e];
        if (e > 0 && elements_[e - 1].number == element.number) return duplicate("elements", element.number);
        const std::uint64_t* nodes = element_nodes_.data() + element.first_node;
        Cell cell;
        for (std::size_t i = 0; i < 4; ++i) {
            ANATOMESH_TRY(cell[i], vertex_of(nodes[i], element));
        }
        model_.mesh.cells.push_back(cell);
        if (nodes_each_ == 4) continue;
        std::array<std::uint32_t, 6> six;
        for (std::size_t i = 0; i < 6; ++i) {
            ANATOMESH_TRY(six[vtk_edge_order[i]], vertex_of(nodes[4 + i], element));
        }
        mid_nodes.push_back(six);
    }
    return mid_nodes.empty() ? Status(Nothing{}) : split_mid_nodes(model_, std::move(mid_nodes), path_);
}

// Of every element, or of none.
Status AbaqusReader::place_materials() {
    if (material_of_element_.empty()) return Nothing{};
    std::sort(material_of_element_.begin(), material_of_element_.end());
    std::vector<std::int64_t> numbers;
    numbers.reserve(elements_.size());
    for (const Element& element : elements_) {
        const auto found =
            std::lower_bound(material_of_element_.begin(), material_of_element_.end(),
                             std::pair{element.number, std::numeric_limits<std::int64_t>::min()});
        const bool there = found != material_of_element_.end() && found->first == element.number;
        numbers.push_back(there ? found->second : 0);
    }
    ANATOMESH_TRY(model_.material, reader_.materials_of_numbers(numbers));
    return Nothing{};
}

// With our table of regions the sets are named REGION_<r>; else every set is a structure, in order of
// occurrence.
Status AbaqusReader::place_regions() {
    std::vector<std::int64_t> of_set;
    for (std::size_t s = 0; s < sets_.size(); ++s) {
        if (!reader_.has_regions()) {
            of_set.push_back(static_cast<std::int64_t>(s) + 1);
            continue;
        }
        std::string_view name = sets_[s];
        const auto region = name.starts_with(region_set)
                                ? number_of<std::int64_t>(name.substr(region_set.size()))
                                : std::nullopt;
        if (!region)
            return mesh_error("E-MDL-011", "an element set is not in the table of regions", path_, sets_[s]);
        of_set.push_back(*region);
    }
    std::vector<std::int64_t> labels;
    labels.reserve(elements_.size());
    for (const Element& element : elements_) labels.push_back(of_set[element.set]);
    if (reader_.has_regions()) {
        ANATOMESH_TRY(model_.mesh.regions, reader_.regions_of_indices(labels));
    } else {
        ANATOMESH_TRY(model_.mesh.regions, reader_.regions_of_labels(labels, labels.size()));
    }
    return Nothing{};
}

Result<ModelFile> AbaqusReader::run(RunContext& context) {
    while (const auto raw = lines_.next()) {
        const std::string_view line = trimmed(*raw);
        if (line.empty()) continue;
        if (line.starts_with("**")) {
            ANATOMESH_CHECK_STATUS(reader_.take(line.substr(2)));
        } else if (line.front() == '*') {
            ANATOMESH_CHECK_STATUS(keyword(line));
        } else if (section_ == Section::nodes) {
            ANATOMESH_CHECK_STATUS(node(line));
        } else if (section_ == Section::tetrahedra) {
            ANATOMESH_CHECK_STATUS(element(line));
        } else if (section_ == Section::material_members) {
            ANATOMESH_CHECK_STATUS(material_member(line));
        } else if (section_ == Section::left_out) {
            ++left_out_;
        }
    }
    ANATOMESH_CHECK_STATUS(unfinished_element());
    if (elements_.empty()) return mesh_error("E-MDL-008", "the file has no tetrahedra (C3D4, C3D10)", path_);
    warn_left_out(left_out_, "tetrahedra", path_, context);
    ANATOMESH_CHECK_STATUS(place_nodes());
    ANATOMESH_CHECK_STATUS(place_elements());
    const bool foreign = !reader_.has_regions();
    ANATOMESH_CHECK_STATUS(place_regions());
    ANATOMESH_CHECK_STATUS(place_materials());
    model_.description = reader_.finish(context);
    if (foreign) {
        for (Structure& structure : model_.description.structures) {
            structure.name = sets_[static_cast<std::size_t>(structure.number) - 1];
        }
    }
    return std::move(model_);
}

}  // namespace

Result<ModelFile> parse_abaqus(const std::string& path, Bytes content, RunContext& context) {
    return AbaqusReader(path, as_text(content)).run(context);
}

}  // namespace anatomesh
