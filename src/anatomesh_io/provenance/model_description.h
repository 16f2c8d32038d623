// The description of a model that was made: what its file says beside points and cells, and how it is read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "anatomesh/pipeline/build_model.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Structures, regions, axes, and the notes of where the model is from: ("version", that of the library),
// ("option", name and value) of each option in its report, ("warning", code and how many times) of each
// warning there, and re-routed contours (routed_contour_notes.h). Nothing of it differs between two
// runs on the same contours; the rest (command, input files and their hashes, every warning in full) stands
// in the report.
MeshDescription description_of(const Model& model);

// The same with the mesh: a file to write with write_model().
ModelFile model_file(const Model& model);

// The values of an option in the notes, in their order: of "priority" "B" and "A", the first first.
std::vector<std::string> options_of(const MeshDescription& description, const std::string& name);

// The first of them; nothing where there is none.
std::optional<std::string> option_of(const MeshDescription& description, const std::string& name);

// The first of them as a number; nothing where there is none.
std::optional<double> number_of(const MeshDescription& description, const std::string& name);

// The edge length that the model was made with, mm, where its file says so.
std::optional<double> size_of(const MeshDescription& description);

}  // namespace anatomesh
