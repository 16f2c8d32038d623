#include "mesh_input.h"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

#include "anatomesh_io/file/detect.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

namespace {

constexpr const char* mesh_extensions =
    "give a model (.vtu, .msh, .mesh, .inp) or a surface (.vtp, .stl, .ply, .obj)";

// A reader's error with a next step, should it have none of its own.
Error with_next_step(Error error) {
    if (!error.next_step.empty()) return error;
    error.next_step = error.code == "E-MDL-006"
                          ? "convert the elements into tetrahedra, or the facets into triangles, first"
                          : "write the file again with the program that made it";
    return error;
}

Result<MeshInput> read_kind(const std::string& path, FileKind kind, const Limits& limits,
                            RunContext& context) {
    MeshInput input;
    switch (kind) {
        case FileKind::vtk_unstructured_grid:
        case FileKind::gmsh:
        case FileKind::medit:
        case FileKind::abaqus: {
            ANATOMESH_TRY(input.model, read_model(path, context, limits.input));
            return input;
        }
        case FileKind::vtk_polydata:
        case FileKind::stl:
        case FileKind::ply:
        case FileKind::obj: {
            ANATOMESH_TRY(input.surface, read_surface(path, context, limits.input));
            return input;
        }
        default:
            return Error{
                ErrorKind::input,
                "E-CMD-012",
                kind == FileKind::unknown
                    ? unknown_content(path)
                    : fmt::format("the file is neither a model nor a surface; its kind is {}", name_of(kind)),
                {path, "", "", "", ""},
                mesh_extensions};
    }
}

}  // namespace

Result<MeshInput> read_mesh(const std::string& path, const Limits& limits, RunContext& context) {
    std::error_code failure;
    if (std::filesystem::is_directory(path, failure)) {
        return Error{ErrorKind::input,
                     "E-CMD-012",
                     unknown_content(path),
                     {path, "", "", "", ""},
                     std::string("give a file of the folder: ") + mesh_extensions};
    }
    ANATOMESH_TRY(const FileKind kind, detect(path));
    Result<MeshInput> input = read_kind(path, kind, limits, context);
    if (!input.ok()) return with_next_step(std::move(input).error());
    return input;
}

std::string unknown_content(const std::string& path) {
    std::error_code failure;
    if (std::filesystem::is_directory(path, failure)) return "the path is a folder, not a file";
    // A message shows so many bytes of a file that no format fits. [bytes; >= 4; B]
    constexpr std::size_t shown_bytes = 12;
    const auto start = read_input_start(path, shown_bytes);
    if (start.ok() && start.value().empty()) return "the file is empty";
    if (!start.ok()) return "the format of the file is not known";
    std::string text, hexadecimal;
    bool plain = true;
    for (const std::byte byte : start.value()) {
        const auto c = std::to_integer<unsigned char>(byte);
        if (c == '\n' || c == '\r') break;
        plain = plain && c >= 0x20 && c < 0x7F;
        text += static_cast<char>(c);
        hexadecimal += fmt::format("{}{:02X}", hexadecimal.empty() ? "" : " ", c);
    }
    return fmt::format("the format of the file is not known; it begins with {}",
                       plain ? "'" + text + "'" : "the bytes " + hexadecimal);
}

SurfaceFile surface_of(const MeshInput& input) {
    return input.surface ? *input.surface : surface_of(*input.model);
}

}  // namespace anatomesh
