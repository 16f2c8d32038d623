#include "anatomesh_io/mesh/description.h"

#include <algorithm>
#include <array>
#include <limits>

#include "anatomesh/base/text.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

// A region is a number of 16 bits, of which 0 is outside. [regions; 65535; D]
constexpr std::size_t max_regions = 65535;

// A name or note on one line: backslash, line feed and carriage return as \\, \n, \r; other control
// characters become blanks.
std::string on_one_line(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '\\':
                result += "\\\\";
                break;
            case '\n':
                result += "\\n";
                break;
            case '\r':
                result += "\\r";
                break;
            default:
                result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
    }
    return result;
}

std::string from_one_line(std::string_view text) {
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '\\' || i + 1 == text.size()) {
            result += text[i];
            continue;
        }
        const char c = text[++i];
        result += c == 'n' ? '\n' : c == 'r' ? '\r' : c;
    }
    return result;
}

bool take_prefix(std::string_view& text, std::string_view prefix) {
    if (!text.starts_with(prefix)) return false;
    text.remove_prefix(prefix.size());
    return true;
}

}  // namespace

std::vector<std::string> description_lines(const MeshDescription& description) {
    std::vector<std::string> lines{"SPACE=" + on_one_line(description.space),
                                   "UNIT=" + on_one_line(description.unit)};
    for (const Structure& structure : description.structures) {
        std::string line = "STRUCTURE " + std::to_string(structure.number);
        for (const std::uint8_t part : structure.color) line += " " + std::to_string(part);
        lines.push_back(line + " " + std::string(trimmed(on_one_line(structure.name))));
    }
    for (std::size_t r = 1; r < description.regions.members.size(); ++r) {
        std::string line = "REGION " + std::to_string(r) + " =";
        for (const std::uint32_t member : description.regions.members[r]) {
            line += " " + std::to_string(description.structures[member].number);
        }
        lines.push_back(std::move(line));
    }
    for (std::size_t m = 0; m < description.materials.size(); ++m) {
        const Material& material = description.materials[m];
        std::string line = "MATERIAL " + std::to_string(m + 1);
        for (const double value : {material.young_mpa, material.poisson, material.density_t_mm3}) {
            line += ' ';
            append_number(line, value);
        }
        lines.push_back(std::move(line));
    }
    for (const auto& [key, value] : description.notes)
        lines.push_back("NOTE " + key + "=" + on_one_line(value));
    for (std::string& line : lines) line = std::string(trimmed(line));
    return lines;
}

Status DescriptionReader::take(std::string_view line) {
    line = trimmed(line);
    if (take_prefix(line, "SPACE=")) {
        description_.space = from_one_line(line);
    } else if (take_prefix(line, "UNIT=")) {
        return take_unit(from_one_line(line));
    } else if (take_prefix(line, "STRUCTURE ")) {
        return take_structure(line);
    } else if (take_prefix(line, "REGION ")) {
        return take_region(line);
    } else if (take_prefix(line, "MATERIAL ")) {
        return take_material(line);
    } else if (take_prefix(line, "NOTE ")) {
        const std::size_t equals = line.find('=');
        if (equals != std::string_view::npos) {
            description_.notes.emplace_back(line.substr(0, equals), from_one_line(line.substr(equals + 1)));
        }
    }
    return Nothing{};
}

Status DescriptionReader::take_unit(const std::string& unit) {
    constexpr std::array<std::string_view, 5> millimetre{"mm", "millimetre", "millimetres", "millimeter",
                                                         "millimeters"};
    if (std::find(millimetre.begin(), millimetre.end(), lower_case(unit)) == millimetre.end()) {
        Error error =
            mesh_error("E-MDL-017", "the unit of the file is not mm", path_, "UNIT=" + unit.substr(0, 60));
        error.next_step = "bring the coordinates to millimetres and write UNIT=mm";
        return error;
    }
    description_.unit = "mm";
    return Nothing{};
}

Status DescriptionReader::take_structure(std::string_view rest) {
    Structure structure;
    const std::string all(rest.substr(0, 60));
    const auto number = take_number<std::int32_t>(rest);
    bool good = number.has_value();
    for (std::uint8_t& part : structure.color) {
        const auto value = take_number<std::uint8_t>(rest);
        good = good && value.has_value();
        part = value.value_or(0);
    }
    if (!good)
        return mesh_error("E-MDL-011", "a structure needs a number, three colours and a name", path_, all);
    structure.number = *number;
    structure.name = from_one_line(trimmed(rest));
    const auto index = static_cast<std::uint32_t>(description_.structures.size());
    if (!index_of_number_.emplace(structure.number, index).second) {
        return mesh_error("E-MDL-011", "two structures have the same number", path_, all);
    }
    description_.structures.push_back(std::move(structure));
    return Nothing{};
}

Status DescriptionReader::take_region(std::string_view rest) {
    const std::string all(rest.substr(0, 60));
    auto& table = description_.regions.members;
    const auto region = take_number<std::size_t>(rest);
    if (!region || *region != table.size() || *region > max_regions || take_word(rest) != "=") {
        return mesh_error("E-MDL-011", "the numbers of regions are not 1, 2, 3 ...", path_, all);
    }
    std::vector<std::uint32_t> members;
    while (!trimmed(rest).empty()) {
        const auto number = take_number<std::int32_t>(rest);
        const auto found = number ? index_of_number_.find(*number) : index_of_number_.end();
        if (found == index_of_number_.end()) {
            return mesh_error("E-MDL-011", "a region names a structure that is not in the table", path_, all);
        }
        members.push_back(found->second);
    }
    std::sort(members.begin(), members.end());
    table.push_back(std::move(members));
    return Nothing{};
}

Status DescriptionReader::take_material(std::string_view rest) {
    const std::string all(rest.substr(0, 60));
    const auto number = take_number<std::size_t>(rest);
    const auto young = take_number<double>(rest), poisson = take_number<double>(rest);
    const auto density = take_number<double>(rest);
    const bool good = number && *number == description_.materials.size() + 1 && young && *young > 0 &&
                      poisson && *poisson > -1 && *poisson < 0.5 && density && *density >= 0;
    if (!good) {
        return mesh_error("E-MDL-011",
                          "a material needs the next number, a Young's modulus, a ratio and a density", path_,
                          all);
    }
    description_.materials.push_back({*young, *poisson, *density});
    return Nothing{};
}

Result<std::vector<std::uint32_t>> DescriptionReader::materials_of_numbers(
    const std::vector<std::int64_t>& numbers) const {
    std::vector<std::uint32_t> materials;
    materials.reserve(numbers.size());
    for (const std::int64_t number : numbers) {
        if (number < 1 || static_cast<std::uint64_t>(number) > description_.materials.size()) {
            return mesh_error("E-MDL-011", "a material is not in the table of materials", path_,
                              std::to_string(number));
        }
        materials.push_back(static_cast<std::uint32_t>(number - 1));
    }
    return materials;
}

Result<std::vector<Region>> DescriptionReader::regions_of_labels(const std::vector<std::int64_t>& labels,
                                                                 std::size_t cells) {
    std::map<std::int64_t, Region> region_of;
    if (has_regions()) {
        const std::vector<std::int32_t> numbers = region_numbers(description_);
        for (std::size_t r = 1; r < numbers.size(); ++r)
            region_of.emplace(numbers[r], static_cast<Region>(r));
        region_of.emplace(0, Region{0});  // cells outside, in the mesh of an early stage
    }
    const bool known = has_regions();
    std::vector<std::int64_t> distinct = labels.empty() ? std::vector<std::int64_t>{1} : labels;
    if (!known) {
        std::sort(distinct.begin(), distinct.end());
        distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
        if (distinct.size() >= max_regions) {
            return mesh_error("E-MDL-010",
                              "the file has " + std::to_string(distinct.size()) + " different labels", path_);
        }
        description_.structures.clear();
        for (const std::int64_t label : distinct) {
            if (label < std::numeric_limits<std::int32_t>::min() ||
                label > std::numeric_limits<std::int32_t>::max()) {
                return mesh_error("E-MDL-010", "a label needs more than 32 bits", path_,
                                  std::to_string(label));
            }
            region_of.emplace(label, static_cast<Region>(description_.regions.members.size()));
            description_.regions.members.push_back(
                {static_cast<std::uint32_t>(description_.structures.size())});
            Structure structure;
            structure.number = static_cast<std::int32_t>(label);
            description_.structures.push_back(std::move(structure));
        }
    }
    std::vector<Region> regions(cells, region_of.empty() ? Region{0} : region_of.begin()->second);
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const auto found = region_of.find(labels[i]);
        if (found == region_of.end()) {
            return mesh_error("E-MDL-011", "a label is not in the table of regions", path_,
                              std::to_string(labels[i]));
        }
        regions[i] = found->second;
    }
    return regions;
}

Result<std::vector<Region>> DescriptionReader::regions_of_indices(
    const std::vector<std::int64_t>& indices) const {
    std::vector<Region> regions(indices.size());
    for (std::size_t i = 0; i < indices.size(); ++i) {
        if (indices[i] < 0 || static_cast<std::uint64_t>(indices[i]) >= description_.regions.members.size()) {
            return mesh_error("E-MDL-011", "a region is not in the table of regions", path_,
                              std::to_string(indices[i]));
        }
        regions[i] = static_cast<Region>(indices[i]);
    }
    return regions;
}

MeshDescription DescriptionReader::finish(RunContext& context) {
    if (description_.space.empty()) {
        description_.space = "unknown";
        Warning warning{"W-MDL-001",
                        "the file does not state the axes of its coordinates (LPS or RAS)",
                        {},
                        "the numbers were kept as mm, with SPACE=unknown"};
        warning.place.file = path_;
        context.warn(std::move(warning));
    }
    return std::move(description_);
}

}  // namespace anatomesh
