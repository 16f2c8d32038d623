// CellSnapshot: where a cell was, whatever it has been cut into since.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/predicates.h"
#include "anatomesh/mesh/edit/edit_mesh.h"

namespace anatomesh {

struct CellSnapshot {
    Cell cell;
    Region region;
    std::array<Vec3, 4> corners;
    Box3 box;

    static CellSnapshot of(const EditMesh& mesh, std::uint32_t c) {
        CellSnapshot is{mesh.cell(c), mesh.region(c), {}, {}};
        for (std::size_t i = 0; i < 4; ++i) {
            is.corners[i] = mesh.point(is.cell[i]);
            is.box.extend(is.corners[i]);
        }
        return is;
    }

    // Whether the point lies in the cell as it was, exactly.
    bool holds(Vec3 p) const {
        const auto& q = corners;
        return box.contains(p) && orient3d(p, q[1], q[2], q[3]) > 0 && orient3d(q[0], p, q[2], q[3]) > 0 &&
               orient3d(q[0], q[1], p, q[3]) > 0 && orient3d(q[0], q[1], q[2], p) > 0;
    }
};

// The first snapshot that holds the centroid of a cell; null if there is none.
inline const CellSnapshot* find_snapshot(const std::vector<CellSnapshot>& cells, const EditMesh& mesh,
                                         std::uint32_t c) {
    Vec3 middle{};
    for (const std::uint32_t v : mesh.cell(c)) middle = middle + 0.25 * mesh.point(v);
    const auto at =
        std::find_if(cells.begin(), cells.end(), [&](const CellSnapshot& was) { return was.holds(middle); });
    return at == cells.end() ? nullptr : &*at;
}

}  // namespace anatomesh
