// Materials of elements from the grey values of an image: a law or a table of Young's modulus, in bins.
//
// Follows: Taddei, Pancanti, Viceconti, "An improved method for the automatic mapping of computed tomography
// numbers onto finite element models", Med. Eng. Phys. 26, 2004; density and power law as collected by
// Helgason et al., Clin. Biomech. 23, 2008.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Linear, isotropic, elastic. Units that fit millimetres: N, tonne, MPa.
struct Material {
    double young_mpa = 0;
    double poisson = 0;
    double density_t_mm3 = 0;  // 0: not known
    friend bool operator==(const Material&, const Material&) = default;
};

// Young's modulus of one structure by grey value.
struct MaterialLaw {
    enum class Kind : std::uint8_t {
        constant,  // young_mpa
        table,     // between the rows of `table` linear, beyond its ends constant
        power  // offset_mpa + factor_mpa * density ^ exponent; density (g/cm3) = intercept + slope * grey, >=
               // 0
    };
    Kind kind = Kind::constant;
    double young_mpa = 0;
    std::vector<std::array<double, 2>> table;  // grey value, MPa; grey values rise
    double intercept = 0, slope = 0;
    double offset_mpa = 0, factor_mpa = 0, exponent = 1;
    double low_mpa = 0,
           high_mpa = std::numeric_limits<double>::infinity();  // the modulus is clamped to this range
    double poisson = 0.3;                                       // in (-1, 0.5)
    double density_g_cm3 = 0;                                   // constant and table: 0 not known
    std::uint32_t bins =
        20;  // of equal width between the smallest and largest modulus of the structure. [1, 1000]
};

// Young's modulus, and the density in g/cm3 (0: not known), where the grey value is `grey`.
double young_modulus(const MaterialLaw& law, double grey);
double density(const MaterialLaw& law, double grey);

struct BinnedMaterials {
    std::vector<Material> materials;     // those that occur: by law, then by rising modulus
    std::vector<std::uint32_t> of_cell;  // index into materials
};

// Cells of equal law whose modulus falls into one bin share a material: its modulus and density are the means
// over their volume, so that the sum of modulus times volume is kept. `law_of_region`: index into laws per
// region. Requires: grey is one finite value per cell, or empty when every law is constant. Error: E-ELM-002
// a modulus that is not above 0 (with the grey value). Linear in the cells.
Result<BinnedMaterials> bin_materials(const TetMesh& mesh, std::span<const double> grey,
                                      std::span<const MaterialLaw> laws,
                                      std::span<const std::uint32_t> law_of_region);

}  // namespace anatomesh
