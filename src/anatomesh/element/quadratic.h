// Quadratic tetrahedra (tet10) of a model's linear ones.
//
// Every edge gets a node. On edges of an interface between two regions it lies on the smooth interface, the
// zero set of the structure's field, straight above the edge's middle; on all other edges, on those of
// contour segments and where more than two regions meet, it lies in the middle. Where an element would come
// too near to folding, its nodes are pulled back towards the middles, down to straight if need be.
//
// Guarantees: corners are those of the mesh; the Jacobian determinant is at least `min_jacobian` of the
// straight element's everywhere in every element, by its Bezier coefficients (jacobian.h), not at sample
// points alone; nodes are numbered by their edges, so that the result does not depend on the number of
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "anatomesh/base/run_context.h"
#include "anatomesh/element/jacobian.h"
#include "anatomesh/field/model/structure_field.h"
#include "anatomesh/mesh/model/mid_nodes.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

struct QuadraticOptions {
    double max_offset = 0.2;  // furthest a node goes from the middle, in lengths of its edge. [0, 0.5]
    double min_jacobian =
        0.2;  // least Jacobian anywhere in an element, in those of the straight one. (0, 0.9]
    double tolerance_mm = 1e-6;  // how near to the interface. [1e-9, 1]
};

struct QuadraticStats {
    std::uint64_t nodes = 0;            // on edges, all of them
    std::uint64_t interface_nodes = 0;  // on edges of interfaces
    std::uint64_t segment_nodes = 0;    // of these, on contour segments: straight
    std::uint64_t junction_nodes = 0;   // of these, where more than two regions meet, or at creases: straight
    std::uint64_t out_of_reach = 0;     // of these, without an interface within max_offset: straight
    std::uint64_t on_interface = 0;     // of these, on the interface in the end
    std::uint64_t pulled_back = 0;      // of these, part of the way to the interface
    std::uint64_t straightened = 0;     // of these, pulled back all the way
    double largest_offset_mm = 0;       // from the middle of the edge, in the end
    double least_jacobian = 1;          // bound over all elements, in those of the straight elements
    double volume_mm3 = 0;              // of all elements
};

struct QuadraticResult {
    MidNodes mid_nodes;
    QuadraticStats stats;
};

// The field of the model: the region at p is the field's at p - origin.
struct ModelField {
    const StructureField& field;
    Vec3 origin;
};

// All nodes in the middles of their edges. O(n log n).
MidNodes straight_mid_nodes(const TetMesh& mesh);

// `segment_edges`: edges along contour segments, in any order. Requires: regions of the mesh are in the
// table, whose members are the field's structures. Error: cancelled. O(n log n), and a few evaluations of the
// field an interface edge.
Result<QuadraticResult> quadratic_elements(const TetMesh& mesh, const RegionTable& regions,
                                           const ModelField& field,
                                           std::span<const std::array<std::uint32_t, 2>> segment_edges,
                                           const QuadraticOptions& options, RunContext& context);

// The element of cell c. Requires: mid_nodes are of this mesh.
inline QuadraticElement element_of(const TetMesh& mesh, const MidNodes& mid_nodes, std::size_t c) {
    QuadraticElement element;
    for (std::size_t i = 0; i < 4; ++i) element.corners[i] = mesh.points[mesh.cells[c][i]];
    for (std::size_t i = 0; i < 6; ++i) element.mid_nodes[i] = mid_nodes.points[mid_nodes.cells[c][i]];
    return element;
}

}  // namespace anatomesh
