// LabelledMeshView: a mesh whose cells have regions, with the field that gave them, as a search reads it.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/mesh/model/tet_mesh.h"
#include "anatomesh/mesh/model/vertex_membership.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// References to what others own: made for one call or for one stage, and valid as long as they do not move it. Nothing
// is changed through a view. All lists are those of one moment: they fit each other.
struct LabelledMeshView {
    const std::vector<Vec3>& points;
    const std::vector<Cell>& cells;
    const std::vector<CellNeighbors>& neighbors;       // by cell; no_cell on the hull
    const std::vector<Region>& regions;                // by cell
    const std::vector<VertexMembership>& memberships;  // by point, as find_memberships() (cull.h) gives them
    const RegionTable& table;                          // of the regions
    const StructureField& field;                       // that regions and memberships come from
    std::uint32_t structures = 0;                      // of the field
};

}  // namespace anatomesh
