// LabelledMesh: the Delaunay mesh of a growing set of points, every cell with its region.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/cull/cull.h"
#include "anatomesh/cull/labelled_mesh_view.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/mesh/model/region_registry.h"

namespace anatomesh {

// What a search that goes over the mesh in rounds has to look at.
struct CellSearch {
    std::vector<std::uint32_t> cells;  // rising
    std::uint32_t seen = 0;            // updates of the mesh that it knows of
};

// After the bulk insertion only what changes is decided anew: cells that an insertion left alone keep their place and
// their region.
class LabelledMesh {
  public:
    // Requires: the field outlives the mesh.
    LabelledMesh(Tetrahedralization delaunay, const StructureField& field, std::uint32_t structures,
                 double size_mm, const SurfaceTolerance& tolerance);

    // Takes the cells as they are now and decides the regions of the new ones.
    CullStats update(RunContext& context);

    // Adds the cells that changed since the search's last look, at first all of them, to those of search.cells, which
    // are cells of the last look that it wants to see again.
    // Whoever changes regions() must begin searches that go by regions anew.
    void look_again(CellSearch& search) const;

    // Returns the vertex of each.
    std::vector<std::uint32_t> insert(std::span<const Vec3> points, int threads);

    const std::vector<Vec3>& points() const { return delaunay_.points(); }
    const DelaunaySnapshot& cells() const { return delaunay_.last_snapshot(); }
    const std::vector<VertexMembership>& memberships() const { return memberships_; }
    std::vector<Region>& regions() { return regions_; }
    const std::vector<Region>& regions() const { return regions_; }
    RegionRegistry& registry() { return registry_; }
    const PointGrid& grid() const { return grid_; }
    // Valid until the next insertion or update.
    LabelledMeshView view() const;
    std::span<const std::uint32_t> first_vertices() const { return delaunay_.first_vertices(); }
    std::uint64_t cells_made() const { return delaunay_.cells_made(); }

  private:
    Tetrahedralization delaunay_;
    const StructureField& field_;
    std::uint32_t structures_;
    SurfaceTolerance tolerance_;
    std::vector<std::vector<std::uint32_t>> changes_;  // the cells that each update brought
    std::uint32_t updates_ = 0;
    std::vector<VertexMembership> memberships_;
    std::vector<Region> regions_;
    RegionRegistry registry_;
    PointGrid grid_;
};

}  // namespace anatomesh
