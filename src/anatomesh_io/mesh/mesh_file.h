// Files of tetrahedral models and of surfaces: what they hold beside the mesh, writing by name, reading by
// content.
//
//   models     .vtu (VTK XML, binary, compressed)  .msh (Gmsh 4.1, binary)  .mesh (Medit)  .inp (Abaqus)
//              .feb (FEBio 4.0, written only)
//   surfaces   .vtp (VTK XML, binary, compressed)  .stl (binary, float32)   .ply (binary, double)  .obj
//
// Every file states its axes and unit. All but .stl keep coordinates exactly and carry the table of
// structures and regions, so that write -> read -> write gives the same bytes. docs/formats.md says what
// stands where.
//
// Errors (kind `input` unless stated), with the file and, in `value`, the line, byte or index:
//   E-MDL-001 (usage) unknown extension            E-MDL-008 no tetrahedra, or no triangles
//   E-MDL-002 content of another kind              E-MDL-009 node or element numbered twice
//   E-MDL-003 malformed: what was expected         E-MDL-010 more labels than regions can be
//   E-MDL-004 names a vertex that does not exist   E-MDL-011 table of structures and regions contradictory
//   E-MDL-005 coordinate not finite, or beyond     E-MDL-012 version or variant of the format not read
//             1e7 mm                               E-MDL-013 (limit) more elements than the format can number
//   E-MDL-006 cell of a kind that is not read      E-MDL-014 (usage) quadratic tetrahedra in .mesh
//   E-MDL-007 more elements claimed than the file can hold
//   E-MDL-016 .vtu, .vtp: cell arrays contradict   E-MDL-017 a unit other than the millimetre
// and those of read_input_file, write_file_atomically and parse_vtk_xml. Warnings:
//   W-MDL-001 the file does not say its axes       W-MDL-004 coordinates lose more than 1e-3 mm in the format
//   W-MDL-002 elements of other kinds left out     W-MDL-005 polygons cut into triangles
//   W-MDL-003 structure numbers <= 0 renumbered    W-MDL-006 grey values or materials left out
//             for a format that cannot hold them   W-MDL-007 .feb without materials: place holders
//   W-MDL-008 values at points left out, in a format that cannot hold them
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/base/structure.h"
#include "anatomesh/element/material.h"
#include "anatomesh/mesh/model/mid_nodes.h"
#include "anatomesh/mesh/model/surface_mesh.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

// What a file says beside points and cells.
struct MeshDescription {
    std::vector<Structure> structures;  // numbers are unique
    RegionTable regions;                // members are indices into structures
    std::string space = "LPS";          // "LPS", "unknown", or what a foreign file says
    std::string unit = "mm";
    // Provenance, in order; keys may repeat: ("version", "0.1.0"), ("warning", "W-RTS-006 ..."), ...
    // Keys are of letters, digits and underscores.
    std::vector<std::pair<std::string, std::string>> notes;
    std::vector<Material> materials{};
};

// A value at every point of the mesh. .vtu and .vtp keep them; the other formats leave them out (W-MDL-008).
// Nodes on edges get the mean of the edge's ends when written; their own in a file are not kept.
struct PointArray {
    std::string name;
    std::vector<float> values;
};

// Requires for writing: regions of cells are in the table, arrays have a value a point. After reading, cells
// are as the file has them: orientation is not checked, and points without a cell are kept.
struct ModelFile {
    TetMesh mesh;
    MeshDescription description;
    MidNodes mid_nodes{};                   // empty: linear tetrahedra
    std::vector<double> grey{};             // per cell, the mean grey value of an image; empty: none
    std::vector<std::uint32_t> material{};  // per cell, index into description.materials; empty: none
    std::vector<PointArray> arrays{};       // of the points of `mesh`
};

struct SurfaceFile {
    SurfaceMesh surface;  // `sides` empty: the file has no regions
    MeshDescription description;
    std::vector<PointArray> arrays{};
};

// The number that files show per region (arrays and sets named `structure`): the structure's own where the
// region is one structure, else a number of its own above all structures' numbers. [0] is 0.
std::vector<std::int32_t> region_numbers(const MeshDescription& description);

enum class ModelFormat : std::uint8_t { vtu, gmsh, medit, abaqus, febio };
enum class SurfaceFormat : std::uint8_t { vtp, stl, ply, obj };

// By the extension, in any case; nothing for others.
std::optional<ModelFormat> model_format_of(const std::string& path);
std::optional<SurfaceFormat> surface_format_of(const std::string& path);

// The file as bytes, for AtomicFileSet. `path` is for messages; the extension chooses the format. The bytes
// do not depend on context.threads. Linear in the size; .vtu and .vtp compress in parallel.
Result<std::string> format_model(const std::string& path, const ModelFile& model, RunContext& context);
Result<std::string> format_surface(const std::string& path, const SurfaceFile& surface, RunContext& context);

// Whether the format can hold quadratic tetrahedra.
bool holds_quadratic(ModelFormat format);

// One file, all or nothing.
Status write_model(const std::string& path, const ModelFile& model, RunContext& context);
Status write_surface(const std::string& path, const SurfaceFile& surface, RunContext& context);

// The format is found by the content. A file without a table of structures gets one structure per label that
// occurs, in increasing order; without labels all is structure 1.
Result<ModelFile> read_model(const std::string& path, RunContext& context, const InputLimits& limits = {});
Result<SurfaceFile> read_surface(const std::string& path, RunContext& context,
                                 const InputLimits& limits = {});

}  // namespace anatomesh
