#include "anatomesh/pipeline/labelled_mesh.h"

namespace anatomesh {

LabelledMesh::LabelledMesh(Tetrahedralization delaunay, const StructureField& field, std::uint32_t structures,
                           double size_mm, double tolerance_mm)
    : delaunay_(std::move(delaunay)), field_(field), structures_(structures), tolerance_mm_(tolerance_mm),
      grid_(size_mm, 2 * delaunay_.points().size()) {
    for (const Vec3& p : delaunay_.points()) grid_.add(p);
}

CullStats LabelledMesh::update(RunContext& context) {
    const std::vector<Region> before = std::move(regions_);
    delaunay_.snapshot(snapshot_);
    regions_.assign(snapshot_.cells.size(), undecided_region);
    for (std::size_t c = 0; c < regions_.size(); ++c) {
        if (snapshot_.previous[c] != no_cell) regions_[c] = before[snapshot_.previous[c]];
    }
    find_sides(points(), field_, structures_, tolerance_mm_, sides_, registry_, context);
    return cull(points(), snapshot_.cells, sides_, field_, structures_, regions_, registry_, context);
}

std::vector<std::uint32_t> LabelledMesh::insert(std::span<const Vec3> points) {
    const std::size_t before = delaunay_.points().size();
    std::vector<std::uint32_t> vertices = delaunay_.insert(points);
    for (std::size_t n = before; n < delaunay_.points().size(); ++n) grid_.add(delaunay_.points()[n]);
    return vertices;
}

}  // namespace anatomesh
