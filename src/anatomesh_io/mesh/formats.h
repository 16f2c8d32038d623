// One writer and one reader per format. `path` is for messages. For the contract see mesh_file.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Error (limit): E-MDL-013 more nodes or elements than readers of the format can number: most keep numbers in 32
// bits, also those of text formats. .vtu and .vtp state 64 bits themselves where they need them.
Status check_numbers(ModelFormat format, std::uint64_t nodes, std::uint64_t elements,
                     const std::string& path);
Status check_numbers(SurfaceFormat format, std::uint64_t nodes, std::uint64_t elements,
                     const std::string& path);

using Bytes = std::span<const std::byte>;

Result<std::string> format_vtu(const std::string& path, const ModelFile& model, RunContext& context);
Result<std::string> format_gmsh(const std::string& path, const ModelFile& model, RunContext& context);
Result<std::string> format_medit(const std::string& path, const ModelFile& model, RunContext& context);
Result<std::string> format_abaqus(const std::string& path, const ModelFile& model, RunContext& context);
Result<std::string> format_febio(const std::string& path, const ModelFile& model, RunContext& context);

Result<ModelFile> parse_vtu(const std::string& path, Bytes content, const InputLimits& limits,
                            RunContext& context);
Result<ModelFile> parse_gmsh(const std::string& path, Bytes content, RunContext& context);
Result<ModelFile> parse_medit(const std::string& path, Bytes content, RunContext& context);
Result<ModelFile> parse_abaqus(const std::string& path, Bytes content, RunContext& context);

Result<std::string> format_vtp(const std::string& path, const SurfaceFile& surface, RunContext& context);
Result<std::string> format_stl(const std::string& path, const SurfaceFile& surface, RunContext& context);
Result<std::string> format_ply(const std::string& path, const SurfaceFile& surface, RunContext& context);
Result<std::string> format_obj(const std::string& path, const SurfaceFile& surface, RunContext& context);

Result<SurfaceFile> parse_vtp(const std::string& path, Bytes content, const InputLimits& limits,
                              RunContext& context);
Result<SurfaceFile> parse_stl(const std::string& path, Bytes content, RunContext& context);
Result<SurfaceFile> parse_ply(const std::string& path, Bytes content, RunContext& context);
Result<SurfaceFile> parse_obj(const std::string& path, Bytes content, RunContext& context);

}  // namespace anatomesh
