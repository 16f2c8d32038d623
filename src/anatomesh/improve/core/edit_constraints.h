// EditConstraints: the vertices and edges of a mesh under improvement that operations must not change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/drawn_slices.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Vertices are fixed or free. Edges with fixed ends are fixed if they lie along contours, and stay chains of
// edges; others are kept as they are until they are released. Edges are named by their ends in any order.
// Complexity: O(log edges) for a question, O(edges) for a change of edges.
class EditConstraints {
  public:
    // `fixed` by vertex, not 0 where it is fixed; it grows with the points. `fixed_edges` are sorted, with
    // fixed ends. Requires: both outlive this.
    EditConstraints(std::vector<std::uint8_t>& fixed, std::span<const VertexPair> fixed_edges);

    std::size_t vertex_count() const { return fixed_.size(); }
    bool fixed(std::uint32_t v) const { return fixed_[v] != 0; }
    void add_free_vertex() { fixed_.push_back(0); }
    void fix(std::uint32_t v) { fixed_[v] = fixed_for_good; }
    void unfix(std::uint32_t v) { fixed_[v] = 0; }
    // The vertex is fixed too, but repair_section_locally() may move it once more.
    void settle(std::uint32_t v) { fixed_[v] = settled_once; }
    bool settled(std::uint32_t v) const { return fixed_[v] == settled_once; }

    bool fixed_edge(std::uint32_t a, std::uint32_t b) const;
    void fix_edge(std::uint32_t a, std::uint32_t b);
    // Takes one fix_edge() back.
    void unfix_edge(std::uint32_t a, std::uint32_t b);

    // The edge stays whole, wherever it lies, until it is released.
    void keep_edge(std::uint32_t a, std::uint32_t b);
    void release_edge(std::uint32_t a, std::uint32_t b);
    void release_edges() { kept_edges_.clear(); }  // all of them
    bool keeps_edge(std::uint32_t a, std::uint32_t b) const;
    bool keeps_any_edge() const { return !kept_edges_.empty(); }
    // Whether the removed cell has a kept edge that none of the added ones has.
    bool loses_kept_edge(const Cell& removed, std::span<const Cell> added) const;

  private:
    static constexpr std::uint8_t fixed_for_good = 1;  // value of a fixed vertex [1; 1 to 255; D]
    static constexpr std::uint8_t settled_once = 2;    // value of a settled vertex [1; 1 to 255; D]

    std::vector<std::uint8_t>& fixed_;
    std::span<const VertexPair> fixed_edges_;
    std::vector<VertexPair> split_edges_;  // that fixed edges were split into; sorted
    std::vector<VertexPair> kept_edges_;   // sorted
};

// SliceVertices knows in which slice's plane a vertex lies as a part of a contour, as drawn or added since.
class SliceVertices {
  public:
    // The new vertex v lies in a slice. Requires: v is larger than those before.
    void add(std::uint32_t v, std::uint32_t slice) { added_.push_back({v, slice}); }
    // The slice of a vertex, or no_slice. `drawn`: by vertex, of those that there were at first. O(log added)
    std::uint32_t slice_of(std::uint32_t v, std::span<const std::uint32_t> drawn) const;

  private:
    std::vector<VertexPair> added_;  // vertex and slice; vertices rise
};

}  // namespace anatomesh
