// remove_spurious_components: components of a region far smaller than a cell, which no contour has drawn, go
// to the region round them.
#pragma once

#include <cstdint>
#include <span>

#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct SpuriousComponentOptions {
    double most_mm3 = 0;  // of a component that is removed. >= 0
};

struct SpuriousComponentStats {
    std::uint64_t components = 0, cells = 0;
};

// A spurious component is a facet-connected part of one region, the outside included, of at most `most_mm3`
// and 64 cells, with no vertex of a contour (`given`, by vertex), none of whose facets are at the end of the
// mesh: a cavity or a speck that is left of a place thinner than the cells. Where all its facets lie between
// it and one other region it takes that. With `regions`, those of the mesh, one between several takes the one
// with which it shares the largest area of those that leave its vertices manifold, if any: what is left of a
// wall between a chamber and the outside. Guarantees: a mesh whose vertices are all manifold (star.h) stays so,
// since at every vertex of a spurious component in one region the spurious component was one component and
// the region beyond the other, and elsewhere it is looked at; no contour vertex leaves its surface, nor a
// segment that is a chain of its edges, since the ends of that are contour vertices of the same piece of
// surface. Requires: `neighbors` as cell_neighbors() gives them. Complexity: O(cells). Same result at any
// number of threads.
SpuriousComponentStats remove_spurious_components(TetMesh& mesh, std::span<const std::uint32_t> neighbors,
                                                  std::span<const std::uint8_t> given,
                                                  const SpuriousComponentOptions& options, int threads = 1,
                                                  const RegionTable* regions = nullptr);

}  // namespace anatomesh
