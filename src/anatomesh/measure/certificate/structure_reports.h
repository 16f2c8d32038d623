// measure_structures: what is said of each structure, but for what contours tell of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/mesh/model/surface_mesh.h"

namespace anatomesh {

using Surfaces = std::vector<std::vector<Triangle>>;           // by structure
using ShellNumbers = std::vector<std::vector<std::uint32_t>>;  // of their triangles

// Fills report.structures, but for volume.slices_mm3 and fidelity, and report.regions. Returns the shell of every
// triangle. `surfaces`: of input.structures, outward; `neighbors`: of the mesh's cells. Guarantees: the same at
// any number of threads. Complexity: O(n log n) in cells and triangles.
ShellNumbers measure_structures(const CertificateInput& input, const Surfaces& surfaces,
                                std::span<const std::uint32_t> neighbors, int threads, ModelReport& report);

// How many facets lie between cells of two regions, or of a region and the outside.
std::uint64_t count_interface_facets(const TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                     int threads);

}  // namespace anatomesh
