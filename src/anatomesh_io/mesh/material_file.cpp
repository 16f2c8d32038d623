#include "anatomesh_io/mesh/material_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "anatomesh_io/file/byte_reader.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

using nlohmann::json;

// A file of materials is no larger, so that a wrong file is refused at once. [bytes; >= 4096; B]
constexpr std::uint64_t max_bytes = std::uint64_t{1} << 20;
// Values nested deeper are refused: the schema has fewer levels. [levels; >= 4; B]
constexpr int max_material_depth = 8;
// Moduli and grey values are below this, so that no law overflows. [MPa, or grey values; > 0; C]
constexpr double most = 1e12;

// Members of one object; the first thing wrong is kept, and every later question answered with a default.
class Reader {
  public:
    Reader(const std::string& path, const json& object, std::string where)
        : path_(path), object_(object), where_(std::move(where)) {
        if (!object.is_object()) fail("", "an object");
    }

    bool has(const char* name) { return good() && take(name) != nullptr; }
    double number(const char* name, double low, double high, std::optional<double> otherwise = {}) {
        const json* value = good() ? take(name) : nullptr;
        if (!value && otherwise) return *otherwise;
        const bool right =
            value && value->is_number() && value->get<double>() >= low && value->get<double>() <= high;
        if (!right) {
            std::string wanted = "a number from ";
            append_number(wanted, low);
            wanted += " to ";
            append_number(wanted, high);
            fail(name, wanted);
            return low;
        }
        return value->get<double>();
    }
    const json& object(const char* name) {
        static const json nothing = json::object();
        const json* value = good() ? take(name) : nullptr;
        if (value && value->is_object()) return *value;
        fail(name, "an object");
        return nothing;
    }
    const json* value(const char* name) { return good() ? take(name) : nullptr; }

    // Members that nobody asked for are mistakes.
    void finish() {
        if (!good()) return;
        for (const auto& item : object_.items()) {
            if (std::find(known_.begin(), known_.end(), item.key()) == known_.end()) {
                return fail(item.key().substr(0, 40), "no such member");
            }
        }
    }
    void fail(const std::string& name, const std::string& wanted) {
        if (error) return;
        error =
            mesh_error("E-MAT-002", "expected " + wanted, path_, where_ + (name.empty() ? "" : "." + name));
    }
    bool good() const { return !error; }
    std::optional<Error> error;

  private:
    const json* take(const char* name) {
        known_.emplace_back(name);
        const auto found = object_.find(name);
        return found == object_.end() ? nullptr : &*found;
    }

    const std::string& path_;
    const json& object_;
    std::string where_;
    std::vector<std::string> known_;
};

void read_table(Reader& reader, const json& rows, MaterialLaw& law) {
    constexpr const char* wanted =
        "an array of rows [grey value, MPa] whose grey values rise and lie within 1e9";
    constexpr const char* wanted_young = "rows [grey value, MPa] whose moduli are above 0 and below 1e9 MPa";
    law.kind = MaterialLaw::Kind::table;
    if (!rows.is_array() || rows.empty()) return reader.fail("table", wanted);
    for (const json& row : rows) {
        const bool right = row.is_array() && row.size() == 2 && row[0].is_number() && row[1].is_number();
        if (!right) return reader.fail("table", wanted);
        law.table.push_back({row[0].get<double>(), row[1].get<double>()});
        const auto& [grey, young] = law.table.back();
        const bool rises = law.table.size() == 1 || law.table[law.table.size() - 2][0] < grey;
        if (!rises || !(std::abs(grey) < most)) return reader.fail("table", wanted);
        if (!(young > 0 && young < most)) return reader.fail("table", wanted_young);
    }
}

Result<NamedLaw> read_law(const std::string& path, const json& object, const std::string& where) {
    Reader reader(path, object, where);
    NamedLaw named;
    MaterialLaw& law = named.law;
    if (const json* structure = reader.value("structure")) {
        if (structure->is_string())
            named.structure = structure->get<std::string>();
        else if (structure->is_number_integer())
            named.structure = structure->dump();
        if (named.structure.empty()) reader.fail("structure", "the name or number of a structure");
    }
    if (const json* optional = reader.value("optional")) {
        if (!optional->is_boolean()) reader.fail("optional", "true or false");
        named.optional = optional->is_boolean() && optional->get<bool>();
    }
    const int kinds = reader.has("young_mpa") + reader.has("table") + reader.has("young_of_density");
    if (reader.good() && kinds != 1) reader.fail("", "one of young_mpa, table, young_of_density");
    if (reader.has("young_mpa")) law.young_mpa = reader.number("young_mpa", 1e-12, most);
    if (const json* rows = reader.value("table")) read_table(reader, *rows, law);
    if (reader.has("young_of_density")) {
        law.kind = MaterialLaw::Kind::power;
        Reader young(path, reader.object("young_of_density"), where + ".young_of_density");
        law.offset_mpa = young.number("offset", -most, most, 0);
        law.factor_mpa = young.number("factor", -most, most);
        law.exponent = young.number("exponent", 0.01, 20, 1);
        young.finish();
        Reader density(path, reader.object("density_of_grey"), where + ".density_of_grey");
        law.intercept = density.number("intercept", -1e6, 1e6, 0);
        law.slope = density.number("slope", -1e6, 1e6);
        density.finish();
        for (Reader* part : {&young, &density}) {
            if (part->error && !reader.error) reader.error = part->error;
        }
    } else {
        law.density_g_cm3 = reader.number("density_g_cm3", 0, 1000, 0);
    }
    law.low_mpa = reader.number("low_mpa", 0, most, 0);
    law.high_mpa = reader.number("high_mpa", law.low_mpa, most, most);
    law.poisson = reader.number("poisson", -0.999, 0.4999, 0.3);
    law.bins = static_cast<std::uint32_t>(reader.number("bins", 1, 1000, 20));
    reader.finish();
    if (reader.error) return *reader.error;
    return named;
}

std::string text_of(const Structure& structure) {
    return structure.name.empty() ? std::to_string(structure.number) : structure.name;
}

Error names_nothing(const NamedLaw& law, std::span<const Structure> structures, const std::string& path) {
    std::string all;
    for (const Structure& structure : structures) all += (all.empty() ? "" : ", ") + text_of(structure);
    Error error = mesh_error(
        "E-MAT-004",
        "a law names a structure that the model does not have; the model has: " + all.substr(0, 400), path);
    error.place.structure = law.structure;
    error.next_step =
        "correct \"structure\" in the law, name the structure with --name, or add \"optional\": true if the "
        "file "
        "is for several models";
    return error;
}

bool names(const NamedLaw& named, const Structure& structure) {
    return named.structure.empty() || named.structure == structure.name ||
           named.structure == std::to_string(structure.number);
}

}  // namespace

Result<MaterialFile> read_material_file(const std::string& path, const InputLimits& limits) {
    InputLimits small = limits;
    small.max_file_bytes = std::min(limits.max_file_bytes, max_bytes);
    ANATOMESH_TRY(const InputFile content, read_input_file(path, small));
    bool too_deep = false;
    const auto watch = [&](int depth, json::parse_event_t, json&) {
        return !(too_deep = too_deep || depth > max_material_depth);
    };
    const json document = json::parse(as_text(content.bytes()), watch, false);
    Reader root(path, document, "file");
    const json* format = root.value("format");
    const json* version = root.value("version");
    if (too_deep || !format || *format != "anatomesh-material" || !version || *version != 1) {
        Error error =
            mesh_error("E-MAT-001", "the file is no JSON file of format anatomesh-material, version 1", path);
        error.next_step = "docs/simulation.md shows one";
        return error;
    }
    MaterialFile file;
    file.path = path;
    file.sha256 = content.sha256();
    file.bytes = content.bytes().size();
    const json* laws = root.value("laws");
    if (!laws || !laws->is_array() || laws->empty()) root.fail("laws", "an array of one law or more");
    root.finish();
    if (root.error) return *root.error;
    for (std::size_t i = 0; i < laws->size(); ++i) {
        ANATOMESH_TRY(NamedLaw law, read_law(path, (*laws)[i], "laws[" + std::to_string(i) + "]"));
        file.laws.push_back(std::move(law));
    }
    return file;
}

bool needs_grey(const MaterialFile& file) {
    return std::any_of(file.laws.begin(), file.laws.end(),
                       [](const NamedLaw& named) { return named.law.kind != MaterialLaw::Kind::constant; });
}

Status check_law_names(const MaterialFile& file, std::span<const Structure> structures,
                       std::span<const Structure> others) {
    for (const NamedLaw& named : file.laws) {
        const auto is_named = [&](const Structure& structure) { return names(named, structure); };
        const bool used = std::any_of(structures.begin(), structures.end(), is_named) ||
                          std::any_of(others.begin(), others.end(), is_named);
        if (!used && !named.optional) return names_nothing(named, structures, file.path);
    }
    return Nothing{};
}

Status apply_materials(ModelFile& model, const MaterialFile& file, std::span<const Structure> others) {
    const MeshDescription& description = model.description;
    ANATOMESH_CHECK_STATUS(check_law_names(file, description.structures, others));
    std::vector<MaterialLaw> laws;
    for (const NamedLaw& named : file.laws) laws.push_back(named.law);
    std::vector<std::uint32_t> law_of_region(description.regions.members.size(), no_cell);
    for (const Region region : model.mesh.regions) {
        if (law_of_region[region] != no_cell) continue;
        const auto& members = description.regions.members[region];
        const auto found = std::find_if(file.laws.begin(), file.laws.end(), [&](const NamedLaw& named) {
            return std::any_of(members.begin(), members.end(),
                               [&](std::uint32_t s) { return names(named, description.structures[s]); });
        });
        if (found == file.laws.end()) {
            Error error = mesh_error("E-MAT-003", "no law applies to this structure", file.path);
            if (!members.empty()) {
                error.place.structure = text_of(description.structures[members.front()]);
            }
            error.next_step = "add one, or a law without \"structure\" for all others";
            return error;
        }
        law_of_region[region] = static_cast<std::uint32_t>(found - file.laws.begin());
    }
    ANATOMESH_TRY(BinnedMaterials binned, bin_materials(model.mesh, model.grey, laws, law_of_region));
    model.description.materials = std::move(binned.materials);
    model.material = std::move(binned.of_cell);
    return Nothing{};
}

std::vector<MaterialRange> material_ranges(const ModelFile& model) {
    const MeshDescription& description = model.description;
    std::vector<MaterialRange> ranges(description.structures.size());
    std::vector<std::vector<bool>> has(ranges.size(), std::vector<bool>(description.materials.size()));
    for (std::size_t s = 0; s < ranges.size(); ++s) ranges[s].structure = text_of(description.structures[s]);
    for (std::size_t c = 0; c < model.material.size(); ++c) {
        const std::uint32_t index = model.material[c];
        const double young = description.materials[index].young_mpa;
        const Cell& cell = model.mesh.cells[c];
        const std::vector<Vec3>& points = model.mesh.points;
        const double volume =
            std::abs(dot(points[cell[1]] - points[cell[0]],
                         cross(points[cell[2]] - points[cell[0]], points[cell[3]] - points[cell[0]]))) /
            6;
        for (const std::uint32_t s : description.regions.members[model.mesh.regions[c]]) {
            MaterialRange& range = ranges[s];
            range.young_low_mpa = range.materials == 0 ? young : std::min(range.young_low_mpa, young);
            range.young_high_mpa = std::max(range.young_high_mpa, young);
            range.materials += !has[s][index];
            has[s][index] = true;
            range.volume_mm3 += volume;
        }
    }
    std::erase_if(ranges, [](const MaterialRange& range) { return range.materials == 0; });
    return ranges;
}

}  // namespace anatomesh
