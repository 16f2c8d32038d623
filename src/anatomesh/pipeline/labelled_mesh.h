// LabelledMesh: the Delaunay mesh of a growing set of points, every cell with its region.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/cull/cull.h"
#include "anatomesh/delaunay/tetrahedralize.h"
#include "anatomesh/field/structure_field.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/mesh/region_registry.h"

namespace anatomesh {

// After the bulk insertion only what changes is decided anew: cells that an insertion left alone keep their region.
class LabelledMesh {
  public:
    // Requires: the field outlives the mesh. `tolerance_mm`: points this near an interface count as on it.
    LabelledMesh(Tetrahedralization delaunay, const StructureField& field, std::uint32_t structures, double size_mm,
                 double tolerance_mm);

    // Takes the cells as they are now and decides the regions of the new ones.
    CullStats update(RunContext& context);

    // Returns the vertex of each.
    std::vector<std::uint32_t> insert(std::span<const Vec3> points);

    const std::vector<Vec3>& points() const { return delaunay_.points(); }
    const DelaunaySnapshot& cells() const { return snapshot_; }
    const std::vector<Region>& sides() const { return sides_; }
    std::vector<Region>& regions() { return regions_; }
    const std::vector<Region>& regions() const { return regions_; }
    RegionRegistry& registry() { return registry_; }
    const PointGrid& grid() const { return grid_; }
    std::span<const std::uint32_t> first_vertices() const { return delaunay_.first_vertices(); }

  private:
    Tetrahedralization delaunay_;
    const StructureField& field_;
    std::uint32_t structures_;
    double tolerance_mm_;
    DelaunaySnapshot snapshot_;
    std::vector<Region> sides_, regions_;
    RegionRegistry registry_;
    PointGrid grid_;
};

}  // namespace anatomesh
