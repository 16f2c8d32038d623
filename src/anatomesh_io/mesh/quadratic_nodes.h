// Quadratic tetrahedra in files: the order of their nodes per format, and covering corners from mid-nodes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh_io/mesh/mesh_file.h"

namespace anatomesh {

// Place n + 4 in an element of the format holds the node of edge [n] of cell_edges.
using EdgeOrder = std::array<std::uint8_t, 6>;
inline constexpr EdgeOrder vtk_edge_order{0, 3, 1, 2, 4, 5};   // Abaqus and FEBio too: 01 12 02 03 13 23
inline constexpr EdgeOrder gmsh_edge_order{0, 3, 1, 2, 5, 4};  // 01 12 02 03 23 13

// Nodes of a file: the points of the mesh, then those on its edges.
inline std::size_t node_count(const ModelFile& model) {
    return model.mesh.points.size() + model.mid_nodes.points.size();
}
inline const Vec3& node_at(const ModelFile& model, std::size_t n) {
    const std::size_t corners = model.mesh.points.size();
    return n < corners ? model.mesh.points[n] : model.mid_nodes.points[n - corners];
}
inline int nodes_per_cell(const ModelFile& model) {
    return model.mid_nodes.empty() ? 4 : 10;
}

// Calls visit(node) for the 4 or 10 nodes of a cell in the format's order, counted from 0.
template <class Visit>
void each_node(const ModelFile& model, std::size_t cell, const EdgeOrder& order, const Visit& visit) {
    for (const std::uint32_t vertex : model.mesh.cells[cell]) visit(std::uint64_t{vertex});
    if (model.mid_nodes.empty()) return;
    for (const std::uint8_t edge : order) {
        visit(std::uint64_t{model.mesh.points.size()} + model.mid_nodes.cells[cell][edge]);
    }
}

// Puts mid-nodes apart from the corners: model.mesh.points holds all nodes of the file, `six` those of every
// cell's cell_edges. Corners and nodes of no cell keep their order in model.mesh.points, mid-nodes theirs in
// model.mid_nodes; model.arrays keep the values of the former. Requires: as many entries as cells; every
// index names a point. Error: E-MDL-015 a node is a corner of one element and on the edge of another.
Status split_mid_nodes(ModelFile& model, std::vector<std::array<std::uint32_t, 6>> six,
                       const std::string& path);

// E-MDL-006: a file with linear and quadratic elements.
Error mixed_orders(const std::string& path, std::string place);

}  // namespace anatomesh
