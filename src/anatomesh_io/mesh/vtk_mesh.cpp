// Models as .vtu and surfaces as .vtp: which arrays stand for what.
#include <algorithm>
#include <array>
#include <limits>

#include "anatomesh/base/parallel.h"
#include "anatomesh/mesh/shape/quality.h"
#include "anatomesh_io/mesh/description.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"
#include "anatomesh_io/mesh/quadratic_nodes.h"
#include "anatomesh_io/mesh/vtk_xml.h"

namespace anatomesh {

namespace {

// This is the type of a tetrahedron with four nodes. [code; 10; D VTK file formats]
constexpr std::uint8_t vtk_tetra = 10;
// This is the type of a tetrahedron with ten nodes. [code; 24; D VTK file formats]
constexpr std::uint8_t vtk_quadratic_tetra = 24;

// VTK cell types of points, lines and faces, which a model may carry beside its tetrahedra.
bool is_lower_dimensional(std::uint8_t type) {
    return type <= 9 || (type >= 21 && type <= 23) || type == 28;
}

std::vector<VtkArray> field_data(const MeshDescription& description) {
    std::vector<std::string> lines = description_lines(description);
    lines.erase(lines.begin(), lines.begin() + 2);  // SPACE and UNIT have arrays of their own
    return {VtkArray::of_strings("SPACE", std::vector<std::string>{description.space}),
            VtkArray::of_strings("UNIT", std::vector<std::string>{description.unit}),
            VtkArray::of_strings("DESCRIPTION", lines)};
}

Status take_field_data(const VtkFile& file, DescriptionReader& reader) {
    for (const char* name : {"SPACE", "UNIT"}) {
        const VtkArray* array = file.field(name);
        if (!array || array->type != VtkType::string) continue;
        const std::vector<std::string> strings = array->to_strings();
        if (!strings.empty()) {
            ANATOMESH_CHECK_STATUS(reader.take(std::string(name) + "=" + strings.front()));
        }
    }
    const VtkArray* lines = file.field("DESCRIPTION");
    if (!lines || lines->type != VtkType::string) return Nothing{};
    for (const std::string& line : lines->to_strings()) {
        ANATOMESH_CHECK_STATUS(reader.take(line));
    }
    return Nothing{};
}

std::string head_comment(const MeshDescription& description) {
    return "SPACE=" + description.space + " UNIT=" + description.unit;
}

std::vector<VtkArray> point_data(const std::vector<PointArray>& arrays) {
    std::vector<VtkArray> data;
    for (const PointArray& array : arrays) data.push_back(VtkArray::of<float>(array.name, array.values));
    return data;
}

// The arrays of a model for all its nodes: those on edges get the mean of the edge's ends.
std::vector<PointArray> with_mid_nodes(const ModelFile& model) {
    std::vector<PointArray> arrays = model.arrays;
    for (PointArray& array : arrays) {
        array.values.resize(node_count(model));
        for (std::size_t c = 0; c < model.mid_nodes.cells.size(); ++c) {
            for (std::size_t e = 0; e < cell_edges.size(); ++e) {
                const float a = array.values[model.mesh.cells[c][cell_edges[e][0]]];
                const float b = array.values[model.mesh.cells[c][cell_edges[e][1]]];
                array.values[model.mesh.points.size() + model.mid_nodes.cells[c][e]] = 0.5F * a + 0.5F * b;
            }
        }
    }
    return arrays;
}

// The arrays of single precision with one value a point.
std::vector<PointArray> point_arrays(const VtkFile& file) {
    std::vector<PointArray> arrays;
    for (const VtkArray& array : file.point_data) {
        if (array.type != VtkType::float32 || array.components != 1) continue;
        const std::vector<double> values = array.to_doubles();
        arrays.push_back({array.name, {values.begin(), values.end()}});
    }
    return arrays;
}

Status check_points(const VtkFile& file, const std::string& path) {
    if (file.points.size() >= no_cell) return mesh_error("E-MDL-013", "more than 2^32 - 2 points", path);
    for (std::size_t i = 0; i < file.points.size(); ++i) {
        ANATOMESH_CHECK_STATUS(check_point(file.points[i], i, path));
    }
    return Nothing{};
}

// A cell array as whole numbers at the chosen cells; empty when there is none of that name with one
// component.
std::vector<std::int64_t> integers_at(const VtkFile& file, const char* name,
                                      const std::vector<std::size_t>& cells) {
    const VtkArray* array = file.cell_array(name);
    if (!array || array->type == VtkType::string || array->components != 1) return {};
    const std::vector<std::int64_t> all = array->to_integers();
    std::vector<std::int64_t> values(cells.size());
    std::transform(cells.begin(), cells.end(), values.begin(), [&](std::size_t cell) { return all[cell]; });
    return values;
}

// Viewers colour by `structure`, and here `region` counts: which of the two is right nobody can tell.
template <class RegionOf>
Status check_structure_array(const VtkFile& file, const std::vector<std::size_t>& cells,
                             const MeshDescription& description, const std::string& path,
                             const RegionOf& region_of) {
    const std::vector<std::int64_t> shown = integers_at(file, "structure", cells);
    const std::vector<std::int32_t> numbers = region_numbers(description);
    for (std::size_t n = 0; n < shown.size(); ++n) {
        if (shown[n] == numbers[region_of(n)]) continue;
        Error error = mesh_error(
            "E-MDL-016", "the arrays `structure` and `region` contradict each other", path,
            "cell " + std::to_string(cells[n]) + ": structure " + std::to_string(shown[n]) + ", region " +
                std::to_string(region_of(n)) + ", which is " + std::to_string(numbers[region_of(n)]));
        error.next_step = "take the model as it was written, or remove the array that is wrong";
        return error;
    }
    return Nothing{};
}

std::vector<double> qualities(const TetMesh& mesh, int threads) {
    std::vector<double> quality(mesh.cells.size());
    parallel_for(mesh.cells.size(), 8192, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const Cell& cell = mesh.cells[c];
            quality[c] = radius_edge_ratio(mesh.points[cell[0]], mesh.points[cell[1]], mesh.points[cell[2]],
                                           mesh.points[cell[3]]);
        }
    });
    return quality;
}

// The number of every cell's material, from 1, and its Young's modulus to look at.
void add_material_arrays(const ModelFile& model, VtkFile& file) {
    std::vector<std::int32_t> numbers;
    std::vector<double> young;
    for (const std::uint32_t m : model.material) {
        numbers.push_back(static_cast<std::int32_t>(m) + 1);
        young.push_back(model.description.materials[m].young_mpa);
    }
    file.cell_data.push_back(VtkArray::of<std::int32_t>("material", numbers));
    file.cell_data.push_back(VtkArray::of<double>("young_mpa", young));
}

// Grey values and materials of a file of ours: a foreign array of that name may mean anything.
Status take_cell_values(const VtkFile& file, const std::vector<std::size_t>& chosen,
                        const DescriptionReader& reader, ModelFile& model) {
    const VtkArray* grey = file.cell_array("grey");
    if (grey && grey->type != VtkType::string && grey->components == 1) {
        const std::vector<double> all = grey->to_doubles();
        for (const std::size_t c : chosen) model.grey.push_back(all[c]);
    }
    if (!reader.has_materials()) return Nothing{};
    ANATOMESH_TRY(model.material, reader.materials_of_numbers(integers_at(file, "material", chosen)));
    return Nothing{};
}

}  // namespace

Result<std::string> format_vtu(const std::string&, const ModelFile& model, RunContext& context) {
    const TetMesh& mesh = model.mesh;
    VtkFile file;
    file.kind = VtkDataSet::unstructured_grid;
    file.points = mesh.points;
    file.points.insert(file.points.end(), model.mid_nodes.points.begin(), model.mid_nodes.points.end());
    file.cells.connectivity.reserve(static_cast<std::size_t>(nodes_per_cell(model)) * mesh.cells.size());
    file.cells.offsets.reserve(mesh.cells.size());
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        each_node(model, c, vtk_edge_order, [&](std::uint64_t node) {
            file.cells.connectivity.push_back(static_cast<std::int64_t>(node));
        });
        file.cells.offsets.push_back(static_cast<std::int64_t>(file.cells.connectivity.size()));
    }
    file.types.assign(mesh.cells.size(), model.mid_nodes.empty() ? vtk_tetra : vtk_quadratic_tetra);

    const std::vector<std::int32_t> number_of_region = region_numbers(model.description);
    std::vector<std::int32_t> numbers(mesh.cells.size());
    for (std::size_t c = 0; c < numbers.size(); ++c) numbers[c] = number_of_region[mesh.regions[c]];
    file.cell_data = {VtkArray::of<std::int32_t>("structure", numbers),
                      VtkArray::of<Region>("region", mesh.regions),
                      VtkArray::of<double>("quality", qualities(mesh, context.threads))};
    if (!model.grey.empty()) file.cell_data.push_back(VtkArray::of<double>("grey", model.grey));
    if (!model.material.empty()) add_material_arrays(model, file);
    file.point_data = point_data(with_mid_nodes(model));
    file.field_data = field_data(model.description);
    return format_vtk_xml(file, head_comment(model.description), {1, context.threads});
}

Result<ModelFile> parse_vtu(const std::string& path, Bytes content, const InputLimits& limits,
                            RunContext& context) {
    ANATOMESH_TRY(VtkFile file, parse_vtk_xml(content, path, limits));
    ANATOMESH_CHECK_STATUS(check_points(file, path));
    DescriptionReader reader(path);
    ANATOMESH_CHECK_STATUS(take_field_data(file, reader));

    ModelFile model;
    std::vector<std::size_t> chosen;
    std::vector<std::array<std::uint32_t, 6>> mid_nodes;
    for (std::size_t c = 0; c < file.cells.size(); ++c) {
        const std::uint8_t type = file.types[c];
        if (is_lower_dimensional(type)) continue;
        const auto points = file.cells.points_of(c);
        const bool quadratic = type == vtk_quadratic_tetra;
        if ((type != vtk_tetra && !quadratic) || points.size() != (quadratic ? 10 : 4)) {
            Error error =
                mesh_error("E-MDL-006", "the program reads tetrahedra of four or ten nodes only", path,
                           "cell " + std::to_string(c) + " of VTK type " + std::to_string(type));
            error.next_step = "turn the cells into tetrahedra first";
            return error;
        }
        if (!chosen.empty() && quadratic == mid_nodes.empty()) {
            return mixed_orders(path, "cell " + std::to_string(c));
        }
        const auto vertex = [](std::int64_t p) { return static_cast<std::uint32_t>(p); };
        Cell cell;
        std::transform(points.begin(), points.begin() + 4, cell.begin(), vertex);
        if (quadratic) {
            std::array<std::uint32_t, 6> six;
            for (std::size_t i = 0; i < 6; ++i) six[vtk_edge_order[i]] = vertex(points[4 + i]);
            mid_nodes.push_back(six);
        }
        model.mesh.cells.push_back(cell);
        chosen.push_back(c);
    }
    if (chosen.empty()) return mesh_error("E-MDL-008", "the file has no tetrahedra", path);
    warn_left_out(file.cells.size() - chosen.size(), "tetrahedra", path, context);
    model.arrays = point_arrays(file);
    model.mesh.points = std::move(file.points);
    if (!mid_nodes.empty()) {
        ANATOMESH_CHECK_STATUS(split_mid_nodes(model, std::move(mid_nodes), path));
    }

    const std::vector<std::int64_t> indices = integers_at(file, "region", chosen);
    if (reader.has_regions() && !indices.empty()) {
        ANATOMESH_TRY(model.mesh.regions, reader.regions_of_indices(indices));
        ANATOMESH_CHECK_STATUS(check_structure_array(file, chosen, reader.description(), path,
                                                     [&](std::size_t c) { return model.mesh.regions[c]; }));
    } else {
        std::vector<std::int64_t> labels;
        for (const char* name :
             {"structure", "label", "Label", "material", "region", "gmsh:physical", "medit:ref"}) {
            labels = integers_at(file, name, chosen);
            if (!labels.empty()) break;
        }
        ANATOMESH_TRY(model.mesh.regions, reader.regions_of_labels(labels, chosen.size()));
    }
    ANATOMESH_CHECK_STATUS(take_cell_values(file, chosen, reader, model));
    model.description = reader.finish(context);
    return model;
}

Result<std::string> format_vtp(const std::string&, const SurfaceFile& surface, RunContext& context) {
    const SurfaceMesh& mesh = surface.surface;
    VtkFile file;
    file.points = mesh.points;
    for (const Triangle& triangle : mesh.triangles) {
        file.polys.add(std::vector<std::int64_t>(triangle.begin(), triangle.end()));
    }
    if (!mesh.sides.empty()) {
        const std::vector<std::int32_t> number_of_region = region_numbers(surface.description);
        std::vector<std::int32_t> numbers;
        std::vector<Region> inner, outer;
        for (const auto& side : mesh.sides) {
            numbers.push_back(number_of_region[side[0]]);
            inner.push_back(side[0]);
            outer.push_back(side[1]);
        }
        file.cell_data = {VtkArray::of<std::int32_t>("structure", numbers),
                          VtkArray::of<Region>("region_in", inner),
                          VtkArray::of<Region>("region_out", outer)};
    }
    file.point_data = point_data(surface.arrays);
    file.field_data = field_data(surface.description);
    return format_vtk_xml(file, head_comment(surface.description), {1, context.threads});
}

Result<SurfaceFile> parse_vtp(const std::string& path, Bytes content, const InputLimits& limits,
                              RunContext& context) {
    ANATOMESH_TRY(VtkFile file, parse_vtk_xml(content, path, limits));
    ANATOMESH_CHECK_STATUS(check_points(file, path));
    DescriptionReader reader(path);
    ANATOMESH_CHECK_STATUS(take_field_data(file, reader));
    SurfaceFile surface;
    std::vector<std::size_t> cell_of;  // per triangle, its cell in the file's cell data
    const auto index = [](std::int64_t p) { return static_cast<std::uint32_t>(p); };
    const auto add = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::size_t cell) {
        surface.surface.triangles.push_back({index(a), index(b), index(c)});
        cell_of.push_back(cell);
    };
    const std::size_t first_strip = file.verts.size() + file.lines.size();
    for (std::size_t s = 0; s < file.strips.size(); ++s) {
        const auto p = file.strips.points_of(s);
        for (std::size_t i = 2; i < p.size(); ++i) {
            // Every second triangle of a strip runs the other way round.
            add(p[i - 2], p[i - (i % 2 == 0 ? 1 : 0)], p[i - (i % 2 == 0 ? 0 : 1)], first_strip + s);
        }
    }
    const std::size_t first_polygon = first_strip + file.strips.size();
    std::size_t polygons = 0;
    for (std::size_t f = 0; f < file.polys.size(); ++f) {
        const auto p = file.polys.points_of(f);
        if (p.size() > 3) ++polygons;
        for (std::size_t i = 2; i < p.size(); ++i) add(p[0], p[i - 1], p[i], first_polygon + f);
    }
    if (cell_of.empty()) return mesh_error("E-MDL-008", "the file has no triangles", path);
    warn_left_out(first_strip, "triangles", path, context);
    warn_polygons(polygons, path, context);
    surface.arrays = point_arrays(file);
    surface.surface.points = std::move(file.points);

    const std::vector<std::int64_t> inner = integers_at(file, "region_in", cell_of);
    const std::vector<std::int64_t> outer = integers_at(file, "region_out", cell_of);
    if (reader.has_regions() && !inner.empty() && !outer.empty()) {
        ANATOMESH_TRY(const std::vector<Region> in, reader.regions_of_indices(inner));
        ANATOMESH_TRY(const std::vector<Region> out, reader.regions_of_indices(outer));
        for (std::size_t i = 0; i < in.size(); ++i) surface.surface.sides.push_back({in[i], out[i]});
        ANATOMESH_CHECK_STATUS(check_structure_array(file, cell_of, reader.description(), path,
                                                     [&](std::size_t t) { return in[t]; }));
    }
    surface.description = reader.finish(context);
    return surface;
}

}  // namespace anatomesh
