// Abaqus .inp: nodes, C3D4 elements by region, an element set per structure, a surface per interface.
// Follows: Abaqus Keywords Reference Guide (*NODE, *ELEMENT, *ELSET, *SURFACE).
#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

// Face of a C3D4 element opposite vertex i: S1 is 1-2-3, S2 is 1-4-2, S3 is 2-4-3, S4 is 3-4-1.
constexpr std::array<const char*, 4> face_opposite{"S3", "S4", "S2", "S1"};

constexpr std::string_view region_set = "REGION_";

struct Interface {
    Region inner = 0, outer = 0;  // inner is the smaller one that is not 0
    std::uint64_t facet = 0;      // 4 cell + i, the cell in `inner`
    friend auto operator<=>(const Interface&, const Interface&) = default;
};

// Every facet between two regions (outside included), by pair of regions, then by facet.
std::vector<Interface> interfaces(const TetMesh& mesh) {
    struct Facet {
        std::array<std::uint32_t, 3> vertices;
        std::uint64_t id;
        auto operator<=>(const Facet&) const = default;
    };
    std::vector<Facet> facets;
    facets.reserve(4 * mesh.cells.size());
    for (std::uint64_t c = 0; c < mesh.cells.size(); ++c) {
        for (std::uint64_t i = 0; i < 4; ++i) {
            Facet facet{{}, 4 * c + i};
            for (std::size_t k = 0; k < 3; ++k) {
                facet.vertices[k] = mesh.cells[c][static_cast<std::size_t>(facet_vertices[i][k])];
            }
            std::sort(facet.vertices.begin(), facet.vertices.end());
            facets.push_back(facet);
        }
    }
    std::sort(facets.begin(), facets.end());
    std::vector<Interface> result;
    const auto region_of = [&](const Facet& facet) { return mesh.regions[facet.id / 4]; };
    for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
        end = begin + 1;
        while (end < facets.size() && facets[end].vertices == facets[begin].vertices) ++end;
        const Facet& first = facets[begin];
        if (end - begin == 1) {
            if (region_of(first) != 0) result.push_back({region_of(first), 0, first.id});
        } else if (const Facet& second = facets[begin + 1]; region_of(first) != region_of(second)) {
            const bool first_inner =
                region_of(second) == 0 || (region_of(first) != 0 && region_of(first) < region_of(second));
            const Facet& inner = first_inner ? first : second;
            const Facet& outer = first_inner ? second : first;
            result.push_back({region_of(inner), region_of(outer), inner.id});
        }
    }
    std::sort(result.begin(), result.end());
    return result;
}

std::string set_name(std::int32_t number) {
    return number < 0 ? "STRUCTURE_M" + std::to_string(-static_cast<std::int64_t>(number))
                      : "STRUCTURE_" + std::to_string(number);
}

void append_nodes(std::string& text, const TetMesh& mesh) {
    text += "*NODE, NSET=ALL\n";
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        append_number(text, i + 1);
        for (const double coordinate : {mesh.points[i].x, mesh.points[i].y, mesh.points[i].z}) {
            text += ", ";
            append_number(text, coordinate);
        }
        text += '\n';
    }
}

void append_elements(std::string& text, const TetMesh& mesh, std::size_t regions) {
    std::vector<std::vector<std::uint32_t>> cells_of(regions);
    for (std::uint32_t c = 0; c < mesh.cells.size(); ++c) cells_of[mesh.regions[c]].push_back(c);
    for (std::size_t r = 0; r < regions; ++r) {
        if (cells_of[r].empty()) continue;
        text += "*ELEMENT, TYPE=C3D4, ELSET=" + std::string(region_set) + std::to_string(r) + "\n";
        for (const std::uint32_t c : cells_of[r]) {
            append_number(text, std::uint64_t{c} + 1);
            for (const std::uint32_t vertex : mesh.cells[c]) {
                text += ", ";
                append_number(text, std::uint64_t{vertex} + 1);
            }
            text += '\n';
        }
    }
}

// A structure is the union of its regions: a set of sets.
void append_structure_sets(std::string& text, const ModelFile& model) {
    std::vector<bool> used(model.description.regions.members.size(), false);
    for (const Region region : model.mesh.regions) used[region] = true;
    for (std::uint32_t s = 0; s < model.description.structures.size(); ++s) {
        std::string members;
        for (std::size_t r = 1; r < used.size(); ++r) {
            if (used[r] && model.description.regions.contains(static_cast<Region>(r), s)) {
                members += std::string(region_set) + std::to_string(r) + "\n";
            }
        }
        if (members.empty()) continue;
        text += "*ELSET, ELSET=" + set_name(model.description.structures[s].number) + "\n" + members;
    }
}

void append_surfaces(std::string& text, const TetMesh& mesh) {
    const std::vector<Interface> facets = interfaces(mesh);
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const Interface& facet = facets[i];
        if (i == 0 || facets[i - 1].inner != facet.inner || facets[i - 1].outer != facet.outer) {
            text += "*SURFACE, TYPE=ELEMENT, NAME=INTERFACE_" + std::to_string(facet.inner) + "_" +
                    std::to_string(facet.outer) + "\n";
        }
        append_number(text, facet.facet / 4 + 1);
        text += ", ";
        text += face_opposite[facet.facet % 4];
        text += '\n';
    }
}

}  // namespace

Result<std::string> format_abaqus(const std::string&, const ModelFile& model, RunContext&) {
    std::string text = "*HEADING\nanatomesh model, SPACE=" + model.description.space +
                       " UNIT=" + model.description.unit + "\n";
    for (const std::string& line : description_lines(model.description)) text += "** " + line + "\n";
    append_nodes(text, model.mesh);
    append_elements(text, model.mesh, model.description.regions.members.size());
    append_structure_sets(text, model);
    append_surfaces(text, model.mesh);
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
    std::array<std::uint64_t, 4> nodes{};
    std::uint32_t set = 0;  // index of its ELSET
};

class AbaqusReader {
  public:
    AbaqusReader(const std::string& path, std::string_view text) : path_(path), reader_(path), lines_(text) {}
    Result<ModelFile> run(RunContext& context);

  private:
    enum class Section : std::uint8_t { other, nodes, tetrahedra, left_out };

    Status keyword(std::string_view line);
    Status node(std::string_view line);
    Status element(std::string_view line);
    Status place_nodes();
    Status place_elements();
    Status place_regions();
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
    std::size_t left_out_ = 0;
    ModelFile model_;
};

Status AbaqusReader::keyword(std::string_view line) {
    std::string_view rest = line;
    const std::string name = lower_case(take_field(rest));
    section_ = Section::other;
    if (name == "*node") {
        section_ = Section::nodes;
    } else if (name == "*element") {
        const std::string type = lower_case(option(rest, "type"));
        if (type == "c3d4") {
            section_ = Section::tetrahedra;
            const std::string set = option(rest, "elset");
            const auto known = std::find(sets_.begin(), sets_.end(), set);
            set_ = static_cast<std::uint32_t>(known - sets_.begin());
            if (known == sets_.end()) sets_.push_back(set);
        } else if (type.starts_with("c3d") || type.starts_with("dc3d")) {
            return mesh_error("E-MDL-006",
                              "only tetrahedra of four vertices (C3D4) are read, not " + type.substr(0, 20),
                              path_, lines_.place());
        } else {
            section_ = Section::left_out;
        }
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

Status AbaqusReader::element(std::string_view line) {
    Element element;
    element.set = set_;
    const auto number = number_of<std::uint64_t>(take_field(line));
    if (!number) return expected(path_, "the number of an element", lines_.place());
    element.number = *number;
    for (std::uint64_t& node : element.nodes) {
        const auto value = number_of<std::uint64_t>(take_field(line));
        if (!value) return expected(path_, "the number of a node", lines_.place());
        node = *value;
    }
    elements_.push_back(element);
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

Status AbaqusReader::place_elements() {
    std::stable_sort(elements_.begin(), elements_.end(),
                     [](const Element& a, const Element& b) { return a.number < b.number; });
    model_.mesh.cells.reserve(elements_.size());
    for (std::size_t e = 0; e < elements_.size(); ++e) {
        if (e > 0 && elements_[e - 1].number == elements_[e].number) {
            return duplicate("elements", elements_[e].number);
        }
        Cell cell;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint64_t number = elements_[e].nodes[i];
            const auto found =
                std::lower_bound(nodes_.begin(), nodes_.end(), number,
                                 [](const auto& node, std::uint64_t n) { return node.first < n; });
            if (found == nodes_.end() || found->first != number) {
                return mesh_error("E-MDL-004",
                                  "an element names node " + std::to_string(number) + ", which is not there",
                                  path_, "element " + std::to_string(elements_[e].number));
            }
            cell[i] = static_cast<std::uint32_t>(found - nodes_.begin());
        }
        model_.mesh.cells.push_back(cell);
    }
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
        } else if (section_ == Section::left_out) {
            ++left_out_;
        }
    }
    if (elements_.empty()) return mesh_error("E-MDL-008", "the file has no tetrahedra (C3D4)", path_);
    warn_left_out(left_out_, "tetrahedra", path_, context);
    ANATOMESH_CHECK_STATUS(place_nodes());
    ANATOMESH_CHECK_STATUS(place_elements());
    const bool foreign = !reader_.has_regions();
    ANATOMESH_CHECK_STATUS(place_regions());
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
