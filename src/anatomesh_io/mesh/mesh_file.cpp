#include "anatomesh_io/mesh/mesh_file.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "anatomesh_io/file/atomic_file.h"
#include "anatomesh_io/file/detect.h"
#include "anatomesh_io/mesh/formats.h"
#include "anatomesh_io/mesh/mesh_text.h"

namespace anatomesh {

namespace {

std::string extension_of(const std::string& path) {
    const std::size_t dot = path.find_last_of("./");
    return dot == std::string::npos || path[dot] == '/' ? "" : lower_case(path.substr(dot + 1));
}

Error unknown_extension(const std::string& path, const char* known) {
    Error error =
        mesh_error("E-MDL-001", "the extension of the output is no format for models or surfaces", path);
    error.kind = ErrorKind::usage;
    error.next_step = std::string("end it in one of ") + known;
    return error;
}

// Formats without values at points.
void warn_of_arrays(const std::vector<PointArray>& arrays, const std::string& path, RunContext& context) {
    if (arrays.empty()) return;
    Warning warning{"W-MDL-008",
                    "the format has no place for values at points, such as " + arrays.front().name,
                    {},
                    "they were left out; .vtu and .vtp keep them"};
    warning.place.file = path;
    context.warn(std::move(warning));
}

Error other_kind(const std::string& path, FileKind kind, const char* wanted) {
    return mesh_error("E-MDL-002",
                      std::string("the content is ") +
                          (kind == FileKind::unknown ? "of no known format" : name_of(kind)) + ", not " +
                          wanted,
                      path);
}

}  // namespace

Error mesh_error(const char* code, std::string message, const std::string& path, std::string value) {
    Error error{ErrorKind::input, code, std::move(message), {}, ""};
    error.place.file = path;
    error.place.value = std::move(value);
    return error;
}

Error expected(const std::string& path, std::string_view what, std::string place) {
    return mesh_error("E-MDL-003", "expected " + std::string(what), path, std::move(place));
}

Status check_point(const Vec3& point, std::size_t index, const std::string& path) {
    for (const double coordinate : {point.x, point.y, point.z}) {
        if (!(std::abs(coordinate) <= coordinate_bound_mm)) {
            return mesh_error("E-MDL-005", "a coordinate is not a number or beyond 1e7 mm", path,
                              "vertex " + std::to_string(index));
        }
    }
    return Nothing{};
}

void warn_left_out(std::size_t count, const char* what, const std::string& path, RunContext& context) {
    if (count == 0) return;
    Warning warning{
        "W-MDL-002", std::to_string(count) + " elements are no " + what, {}, "they were left out"};
    warning.place.file = path;
    context.warn(std::move(warning));
}

void warn_polygons(std::size_t count, const std::string& path, RunContext& context) {
    if (count == 0) return;
    Warning warning{"W-MDL-005",
                    std::to_string(count) + " polygons have more than three vertices",
                    {},
                    "they were divided into triangles"};
    warning.place.file = path;
    context.warn(std::move(warning));
}

void warn_cell_values(const char* what, const std::string& path, RunContext& context) {
    Warning warning{
        "W-MDL-006", std::string("the format has no place for ") + what, {}, "they were left out"};
    warning.place.file = path;
    context.warn(std::move(warning));
}

std::vector<std::int32_t> region_numbers(const MeshDescription& description) {
    std::vector<std::int32_t> used;
    for (const Structure& structure : description.structures) used.push_back(structure.number);
    std::sort(used.begin(), used.end());
    std::int64_t next = used.empty() ? 1 : std::max<std::int64_t>(used.back(), 0) + 1;
    // Without room above: the smallest numbers that are free.
    if (next + static_cast<std::int64_t>(description.regions.members.size()) >
        std::numeric_limits<std::int32_t>::max()) {
        next = 1;
    }
    std::vector<std::int32_t> numbers(description.regions.members.size(), 0);
    for (std::size_t r = 1; r < numbers.size(); ++r) {
        const auto& members = description.regions.members[r];
        if (members.size() == 1) {
            numbers[r] = description.structures[members.front()].number;
            continue;
        }
        while (std::binary_search(used.begin(), used.end(), next)) ++next;
        numbers[r] = static_cast<std::int32_t>(next++);
    }
    return numbers;
}

std::optional<ModelFormat> model_format_of(const std::string& path) {
    const std::string extension = extension_of(path);
    if (extension == "vtu") return ModelFormat::vtu;
    if (extension == "msh") return ModelFormat::gmsh;
    if (extension == "mesh") return ModelFormat::medit;
    if (extension == "inp") return ModelFormat::abaqus;
    if (extension == "feb") return ModelFormat::febio;
    return std::nullopt;
}

std::optional<SurfaceFormat> surface_format_of(const std::string& path) {
    const std::string extension = extension_of(path);
    if (extension == "vtp") return SurfaceFormat::vtp;
    if (extension == "stl") return SurfaceFormat::stl;
    if (extension == "ply") return SurfaceFormat::ply;
    if (extension == "obj") return SurfaceFormat::obj;
    return std::nullopt;
}

namespace {

// Readers keep the number of a node or element as a signed integer of 32 bits.
// [elements; 2^31 - 1; D Gmsh 4.1 (int), PLY (int); for texts what their readers can hold]
constexpr std::uint64_t most_numbered = 0x7FFFFFFF;
// STL states how many triangles there are, and numbers none. [triangles; 2^32 - 1; D]
constexpr std::uint64_t most_stl_triangles = 0xFFFFFFFF;

Status check_count(const char* what, std::uint64_t count, std::uint64_t largest, const std::string& path) {
    if (count <= largest) return Nothing{};
    return Error{ErrorKind::limit,
                 "E-MDL-013",
                 "the file would have more " + std::string(what) + " than its format can number, which is " +
                     std::to_string(largest),
                 {path, "", "", "", std::to_string(count)},
                 "write .vtu or .vtp, or make a coarser model"};
}

}  // namespace

Status check_numbers(ModelFormat format, std::uint64_t nodes, std::uint64_t elements,
                     const std::string& path) {
    if (format == ModelFormat::vtu) return Nothing{};
    ANATOMESH_CHECK_STATUS(check_count("nodes", nodes, most_numbered, path));
    return check_count("elements", elements, most_numbered, path);
}

Status check_numbers(SurfaceFormat format, std::uint64_t nodes, std::uint64_t elements,
                     const std::string& path) {
    if (format == SurfaceFormat::vtp) return Nothing{};
    if (format == SurfaceFormat::stl) return check_count("triangles", elements, most_stl_triangles, path);
    ANATOMESH_CHECK_STATUS(check_count("vertices", nodes, most_numbered, path));
    return check_count("triangles", elements, most_numbered, path);
}

Result<std::string> format_model(const std::string& path, const ModelFile& model, RunContext& context) {
    assert(model.mesh.regions.size() == model.mesh.cells.size());
    assert(model.mid_nodes.empty() || model.mid_nodes.cells.size() == model.mesh.cells.size());
    assert(model.grey.empty() || model.grey.size() == model.mesh.cells.size());
    assert(model.material.empty() || model.material.size() == model.mesh.cells.size());
    const auto format = model_format_of(path);
    if (!format) return unknown_extension(path, ".vtu, .msh, .mesh, .inp, .feb");
    ANATOMESH_CHECK_STATUS(check_numbers(*format, model.mesh.points.size() + model.mid_nodes.points.size(),
                                         model.mesh.cells.size(), path));
    if (*format != ModelFormat::vtu) warn_of_arrays(model.arrays, path, context);
    switch (*format) {
        case ModelFormat::vtu:
            return format_vtu(path, model, context);
        case ModelFormat::gmsh:
            return format_gmsh(path, model, context);
        case ModelFormat::medit:
            return format_medit(path, model, context);
        case ModelFormat::febio:
            return format_febio(path, model, context);
        case ModelFormat::abaqus:
            break;
    }
    return format_abaqus(path, model, context);
}

bool holds_quadratic(ModelFormat format) {
    return format != ModelFormat::medit;
}

Result<std::string> format_surface(const std::string& path, const SurfaceFile& surface, RunContext& context) {
    assert(surface.surface.sides.empty() || surface.surface.sides.size() == surface.surface.triangles.size());
    const auto format = surface_format_of(path);
    if (!format) return unknown_extension(path, ".vtp, .stl, .ply, .obj");
    ANATOMESH_CHECK_STATUS(
        check_numbers(*format, surface.surface.points.size(), surface.surface.triangles.size(), path));
    if (*format != SurfaceFormat::vtp) warn_of_arrays(surface.arrays, path, context);
    switch (*format) {
        case SurfaceFormat::vtp:
            return format_vtp(path, surface, context);
        case SurfaceFormat::stl:
            return format_stl(path, surface, context);
        case SurfaceFormat::ply:
            return format_ply(path, surface, context);
        case SurfaceFormat::obj:
            break;
    }
    return format_obj(path, surface, context);
}

Status write_model(const std::string& path, const ModelFile& model, RunContext& context) {
    ANATOMESH_TRY(const std::string bytes, format_model(path, model, context));
    return write_file_atomically(path, bytes);
}

Status write_surface(const std::string& path, const SurfaceFile& surface, RunContext& context) {
    ANATOMESH_TRY(const std::string bytes, format_surface(path, surface, context));
    return write_file_atomically(path, bytes);
}

Result<ModelFile> read_model(const std::string& path, RunContext& context, const InputLimits& limits) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, limits));
    const FileKind kind = detect_bytes(file.bytes());
    switch (kind) {
        case FileKind::vtk_unstructured_grid:
            return parse_vtu(path, file.bytes(), limits, context);
        case FileKind::gmsh:
            return parse_gmsh(path, file.bytes(), context);
        case FileKind::medit:
            return parse_medit(path, file.bytes(), context);
        case FileKind::abaqus:
            return parse_abaqus(path, file.bytes(), context);
        default:
            return other_kind(path, kind, "a tetrahedral model (.vtu, .msh, .mesh, .inp)");
    }
}

Result<SurfaceFile> read_surface(const std::string& path, RunContext& context, const InputLimits& limits) {
    ANATOMESH_TRY(const InputFile file, read_input_file(path, limits));
    const FileKind kind = detect_bytes(file.bytes());
    switch (kind) {
        case FileKind::vtk_polydata:
            return parse_vtp(path, file.bytes(), limits, context);
        case FileKind::stl:
            return parse_stl(path, file.bytes(), context);
        case FileKind::ply:
            return parse_ply(path, file.bytes(), context);
        case FileKind::obj:
            return parse_obj(path, file.bytes(), context);
        default:
            return other_kind(path, kind, "a surface (.vtp, .stl, .ply, .obj)");
    }
}

}  // namespace anatomesh
