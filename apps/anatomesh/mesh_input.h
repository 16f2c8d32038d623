// Inputs of the verbs that take a model or a surface.
#pragma once

#include <optional>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "anatomesh_io/mesh/surface_of_model.h"
#include "limits.h"

namespace anatomesh {

// One of the two.
struct MeshInput {
    std::optional<ModelFile> model;
    std::optional<SurfaceFile> surface;
};

// By content. Errors: those of the readers; E-CMD-012 a kind of file that is neither.
Result<MeshInput> read_mesh(const std::string& path, const Limits& limits, RunContext& context);

// What a file of no known kind is, as far as its first bytes tell: "a folder", "the file is empty", "the
// content, which begins with ..., is of no known kind".
std::string unknown_content(const std::string& path);

// The surface of a model (surface_of_model.h); a surface as it is.
SurfaceFile surface_of(const MeshInput& input);

}  // namespace anatomesh
