#include "anatomesh/pipeline/labelled_mesh.h"

#include <algorithm>
#include <iterator>

namespace anatomesh {

namespace {

constexpr std::size_t few = 20;  // one cell in so many is sorted sooner than all are looked through

}  // namespace

LabelledMesh::LabelledMesh(Tetrahedralization delaunay, const StructureField& field, std::uint32_t structures,
                           double size_mm, double tolerance_mm)
    : delaunay_(std::move(delaunay)),
      field_(field),
      structures_(structures),
      tolerance_mm_(tolerance_mm),
      registry_(field.exclusive()),
      grid_(size_mm, 2 * delaunay_.points().size()) {
    for (const Vec3& p : delaunay_.points()) grid_.add(p);
}

CullStats LabelledMesh::update(RunContext& context) {
    const DelaunaySnapshot& now = delaunay_.snapshot(context.threads);
    ++updates_;
    regions_.resize(now.cells.size());
    changed_at_.resize(now.cells.size());
    for (const std::uint32_t c : now.changed) changed_at_[c] = updates_;
    changes_.push_back(now.changed);
    find_sides(points(), field_, structures_, tolerance_mm_, sides_, registry_, context);
    return cull(points(), now.cells, now.changed, sides_, field_, structures_, regions_, registry_, context);
}

void LabelledMesh::look_again(CellSearch& search) const {
    std::size_t count = search.cells.size();
    for (std::uint32_t u = search.seen; u < updates_; ++u) count += changes_[u].size();
    if (count * few < changed_at_.size()) {
        for (std::uint32_t u = search.seen; u < updates_; ++u) {
            std::copy_if(changes_[u].begin(), changes_[u].end(), std::back_inserter(search.cells),
                         [&](std::uint32_t c) { return c < changed_at_.size(); });
        }
        std::sort(search.cells.begin(), search.cells.end());
        search.cells.erase(std::unique(search.cells.begin(), search.cells.end()), search.cells.end());
    } else {
        std::vector<std::uint32_t> cells;
        auto again = search.cells.begin();
        for (std::uint32_t c = 0; c < changed_at_.size(); ++c) {
            const bool wanted = again != search.cells.end() && *again == c;
            if (wanted || changed_at_[c] > search.seen) cells.push_back(c);
            again += wanted;
        }
        search.cells = std::move(cells);
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
