#include "mesh_input.h"

#include <fmt/format.h>

#include "anatomesh/mesh/topology.h"
#include "anatomesh_io/file/detect.h"

namespace anatomesh {

Result<MeshInput> read_mesh(const std::string& path, RunContext& context) {
    ANATOMESH_TRY(const FileKind kind, detect(path));
    MeshInput input;
    switch (kind) {
        case FileKind::vtk_unstructured_grid:
        case FileKind::gmsh:
        case FileKind::medit:
        case FileKind::abaqus: {
            ANATOMESH_TRY(input.model, read_model(path, context));
            return input;
        }
        case FileKind::vtk_polydata:
        case FileKind::stl:
        case FileKind::ply:
        case FileKind::obj: {
            ANATOMESH_TRY(input.surface, read_surface(path, context));
            return input;
        }
        default:
            return Error{ErrorKind::input,
                         "E-CMD-012",
                         kind == FileKind::unknown
                             ? std::string("the content is of no known kind")
                             : fmt::format("a {} is neither a model nor a surface", name_of(kind)),
                         {path, "", "", "", ""},
                         "models are .vtu, .msh, .mesh and .inp, surfaces .vtp, .stl, .ply and .obj"};
    }
}

SurfaceFile surface_of(const MeshInput& input) {
    if (input.surface) return *input.surface;
    return {extract_interfaces(input.model->mesh), input.model->description};
}

}  // namespace anatomesh
