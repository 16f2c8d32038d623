// What a model gets for simulation: quadratic elements, grey values, materials. Options of `model` and
// `convert`.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/measure/report.h"
#include "anatomesh_io/mesh/material_file.h"
#include "anatomesh_io/mesh/mesh_file.h"
#include "input_options.h"
#include "session.h"

namespace anatomesh {

struct ElementOptions {
    std::uint32_t order = 0;  // 1 or 2; 0: not given
    std::string grey;         // an image
    std::string material;     // a file of laws
    bool wanted() const { return !grey.empty() || !material.empty(); }
    std::vector<std::string> inputs() const;  // the files named
};

void add_element_options(CLI::App& verb, ElementOptions& options);

// The format of `output` can hold quadratic elements where they are asked for. Error: usage E-MDL-014.
Status check_order(const ElementOptions& options, const std::string& output);

// Refuses before the mesh is made what add_cell_values() would refuse after it: a file of laws that cannot be read, that
// names no structure of the model, or that needs grey values where there are none. `has_grey`: the model is made from a
// grey image.
Status check_materials(const ElementOptions& options, std::span<const Structure> structures, bool has_grey,
                       const InputLimits& limits);

// What was read and done, for the report.
struct CellValues {
    std::vector<InputReport> files;
    std::vector<StageReport> stages;
    std::vector<MaterialRange> materials;  // of each structure
};

// A line for each structure: how many materials it has, its volume and the range of Young's modulus.
std::string materials_text(const std::vector<MaterialRange>& materials);

// Puts grey values and materials into the model, as far as they are asked for. `own` is the input of the
// model when it was made from a grey image in this run (whose values count without --grey), else nothing.
// Errors: those of the readers and stages; E-CMD-012 --grey is no image; usage E-CMD-008 a law needs grey
// values and there are none. Warning: W-ELM-001 cells outside the image.
// `others`: structures of models beside it, which laws may name.
Result<CellValues> add_cell_values(ModelFile& model, const ElementOptions& options, const InputOptions* own,
                                   Session& session, std::span<const Structure> others = {});

}  // namespace anatomesh
