// NonmanifoldPatch: the part of a mesh round its non-manifold vertices, taken out of the mesh to be rebuilt.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/mesh/model/region_registry.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

// Small enough for its neighbours to be found anew after every pass.
struct NonmanifoldPatch {
    std::vector<Vec3>& points;  // of the whole mesh; only appended to
    const ContourOwners& owners;
    RegionRegistry& registry;
    std::vector<Cell> cells;
    std::vector<Region> regions;
    std::vector<CellNeighbors> neighbors;
    std::vector<std::uint32_t>
        watched;  // vertices whose stars lie wholly in the patch and may be non-manifold

    // Takes all cells out of the mesh that touch a vertex of the stars of these vertices.
    static NonmanifoldPatch take_from(TetMesh& mesh, const std::vector<std::uint32_t>& vertices,
                                      const ContourOwners& owners, RegionRegistry& registry);
    // Appends its cells to those that stayed in the mesh.
    void put_back(TetMesh& mesh) const;

    const RegionTable& table() const { return registry.table(); }
    void find_neighbors();
};

// The stars of a patch and its non-manifold vertices, while cells stay; regions may change.
struct PatchStars {
    explicit PatchStars(const NonmanifoldPatch& patch);
    PatchStars(const PatchStars&) = delete;
    PatchStars& operator=(const PatchStars&) = delete;

    VertexStars stars;
    StarAnalyzer analyzer;
    std::vector<std::uint32_t> nonmanifold;  // as they were found; in the order of watched
};

struct LabelledCells {
    std::vector<Cell> cells;
    std::vector<Region> regions;

    void add(Cell cell, Region region) {
        cells.push_back(cell);
        regions.push_back(region);
    }
    // Cuts a prism with triangle (a0, a1, a2) at one end and (b0, b1, b2) at the other into three cells. The diagonal of
    // each side starts at the side's smallest vertex, so that two prisms agree on the side they share (Dompierre, Labbe,
    // Vallet and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra, 1999). Their orientation is
    // turned by fits().
    void add_prism(std::array<std::uint32_t, 3> a, std::array<std::uint32_t, 3> b, Region region);
};

// What one pass takes out of the patch and puts in.
struct PatchChange {
    explicit PatchChange(const NonmanifoldPatch& patch) : removed(patch.cells.size(), 0) {}

    std::vector<std::uint8_t> removed;  // by cell
    LabelledCells added;
    std::uint64_t points_added = 0, cells_added = 0;  // more than were removed

    bool touches(std::span<const std::uint32_t> cells) const;
    // Puts `cells` in the place of `old`; the patch's points from `first_new` on are theirs and are watched.
    void replace(NonmanifoldPatch& patch, std::span<const std::uint32_t> old, const LabelledCells& cells,
                 std::uint32_t first_new);
    void apply(NonmanifoldPatch& patch) const;
};

// Turns every cell positive. Says whether the cells fill the place of those removed: not if one is flat, nor if
// a new point was rounded to the other side of one nearly so, which then lies over its neighbours.
bool fits(const NonmanifoldPatch& patch, std::span<const std::uint32_t> removed, LabelledCells& added);

}  // namespace anatomesh
