#include "anatomesh/refine/labelled_mesh.h"

#include <numeric>

#include "anatomesh/base/sort_distinct.h"

namespace anatomesh {

LabelledMesh::LabelledMesh(Tetrahedralization delaunay, const StructureField& field, std::uint32_t structures,
                           double size_mm, const SurfaceTolerance& tolerance)
    : delaunay_(std::move(delaunay)),
      field_(field),
      structures_(structures),
      tolerance_(tolerance),
      registry_(field.exclusive()),
      grid_(size_mm, 2 * delaunay_.points().size()) {
    for (const Vec3& p : delaunay_.points()) grid_.add(p);
}

CullStats LabelledMesh::update(RunContext& context) {
    const DelaunaySnapshot& now = delaunay_.snapshot(context.threads);
    ++updates_;
    regions_.resize(now.cells.size());
    changes_.push_back(now.changed);
    const ChosenCells changed{points(), now.cells, now.changed};
    find_memberships(changed, field_, structures_, tolerance_, memberships_, registry_, context);
    return cull(changed, memberships_, field_, structures_, regions_, registry_, context);
}

LabelledMeshView LabelledMesh::view() const {
    return {points(),          cells().cells, cells().neighbors, regions_, memberships_,
            registry_.table(), field_,        structures_};
}

void LabelledMesh::look_again(CellSearch& search) const {
    const std::size_t count = cells().cells.size();
    if (search.seen == 0) {
        search.cells.resize(count);
        std::iota(search.cells.begin(), search.cells.end(), 0u);
    } else if (search.seen < updates_) {
        for (std::uint32_t u = search.seen; u < updates_; ++u)
            search.cells.insert(search.cells.end(), changes_[u].begin(), changes_[u].end());
        std::erase_if(search.cells, [&](std::uint32_t c) { return c >= count; });
        sort_distinct(search.cells, count);
    }
    search.seen = updates_;
}

std::vector<std::uint32_t> LabelledMesh::insert(std::span<const Vec3> points, int threads) {
    const std::size_t before = delaunay_.points().size();
    std::vector<std::uint32_t> vertices = delaunay_.insert(points, threads);
    for (std::size_t n = before; n < delaunay_.points().size(); ++n) grid_.add(delaunay_.points()[n]);
    return vertices;
}

}  // namespace anatomesh
