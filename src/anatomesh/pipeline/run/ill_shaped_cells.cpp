#include "anatomesh/pipeline/run/ill_shaped_cells.h"

#include <cmath>
#include <numbers>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/parallel.h"
#include "anatomesh/measure/certificate/certificate.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

std::vector<std::uint32_t> ill_shaped_cells(const TetMesh& mesh, std::size_t threads) {
    const double squared_ratio = contract::bad_radius_edge * contract::bad_radius_edge;
    const double sine = std::sin(contract::bad_dihedral_degrees * std::numbers::pi / 180);
    return parallel_collect<std::uint32_t>(
        mesh.cells.size(), 16384, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            for (std::size_t c = first; c < last; ++c) {
                if (mesh.regions[c] == 0) continue;
                const Cell& v = mesh.cells[c];
                const CellMeasures m =
                    measure_cell(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
                if (m.squared_ratio > squared_ratio || m.least_sine() < sine)
                    found.push_back(static_cast<std::uint32_t>(c));
            }
        });
}

}  // namespace anatomesh
