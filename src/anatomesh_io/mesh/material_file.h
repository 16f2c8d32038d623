// Material laws from a small JSON file (docs/simulation.md).
//
//   {"format": "anatomesh-material", "version": 1,
//    "laws": [{"structure": "skull", "density_of_grey": {"intercept": 0.05, "slope": 0.0008},
//              "young_of_density": {"offset": 0, "factor": 6850, "exponent": 1.49}, "poisson": 0.3, "bins":
//              20},
//             {"structure": 7, "table": [[-100, 0.01], [300, 1000]]},
//             {"young_mpa": 1}]}
//
// Errors: input E-MAT-001 not JSON, or of another kind; E-MAT-002 a member is missing, unknown, of another
// type or out of range (which one, and what is wanted); E-MAT-003 a structure has no law; E-MAT-004 a law names no
// structure of the model and is not optional; those of read_input_file.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "anatomesh/element/material.h"
#include "anatomesh_io/file/input_file.h"
#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

struct NamedLaw {
    std::string structure;  // a name or a number; empty: every structure
    bool optional = false;  // the model need not have the structure: the file is for several models
    MaterialLaw law;
};

struct MaterialFile {
    std::vector<NamedLaw> laws;
    std::string path, sha256;
    std::uint64_t bytes = 0;
};

Result<MaterialFile> read_material_file(const std::string& path, const InputLimits& limits);

// Whether any law depends on the grey value.
bool needs_grey(const MaterialFile& file);

// Whether every law names one of `structures` or `others`, or is optional. Error: E-MAT-004.
Status check_law_names(const MaterialFile& file, std::span<const Structure> structures,
                       std::span<const Structure> others = {});

// Gives every cell its material: that of the first law which names a structure of the cell's region, or none.
// `others`: structures of models beside it that the laws are for as well. Requires: model.grey is set when a law needs
// it. Errors: E-MAT-003; E-MAT-004; E-ELM-002.
Status apply_materials(ModelFile& model, const MaterialFile& file, std::span<const Structure> others = {});

// What materials a structure has: how many, in how much of it, and from which modulus to which.
struct MaterialRange {
    std::string structure;
    std::size_t materials = 0;
    double volume_mm3 = 0, young_low_mpa = 0, young_high_mpa = 0;
};

// Of each structure of a model with materials, in order. A cell of several structures counts for each. O(cells).
std::vector<MaterialRange> material_ranges(const ModelFile& model);

}  // namespace anatomesh
