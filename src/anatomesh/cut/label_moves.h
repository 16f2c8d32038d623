// LabelMoves: the moves that are tried at a vertex of a mesh whose cells are relabelled.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/cut/drawn_sections.h"
#include "anatomesh/cut/label_singularities.h"

namespace anatomesh {

// Each function appends its moves to `moves`, in an order that depends on the mesh alone. Their cells and region are
// filled, what comes of them is not. New sets of structures are interned in that order. Requires: the mesh outlives
// this. Keeps scratch space: not thread-safe. Complexity: O(cells at the vertex), beside a star its cells' cells.
class LabelMoves {
  public:
    explicit LabelMoves(const RelabelledMesh& mesh) : mesh_(mesh) {}

    // A whole component goes to the region with which it shares most facets of the star across its body's surface.
    void add_component(const StarComponent& component, std::vector<LabelMove>& moves);

    // Cells of the star join the component to the nearest other one of its side. Where a structure touches itself in a
    // point of a slice, this leaves the cross-section as it is drawn if they lie above the plane or below it; so both
    // are tried.
    void add_bridges(std::uint32_t vertex, const StarComponent& component, const DrawnSections& sections,
                     std::vector<LabelMove>& moves);

    // Each cell of the component by itself goes to a region beside it.
    void add_single_cells(const StarComponent& component, std::vector<LabelMove>& moves);

    // A structure is to have a vertex on its surface: one cell at the vertex, or it and the one behind it, changes
    // sides, joined to cells of that side.
    void add_regaining(std::uint32_t vertex, std::uint32_t structure, std::vector<LabelMove>& moves);

    // A structure is to have a subsegment on its surface: a cell at the edge, or it and one of those beside or behind
    // it, changes sides, joined to cells of that side.
    void add_regaining(std::uint32_t vertex, ContourOwners::Subsegment subsegment,
                       std::vector<LabelMove>& moves);

    // Whether four contour segments or more end there.
    bool touches_in_point(std::uint32_t vertex) const;

  private:
    void add_bridge(std::uint32_t vertex, const StarComponent& component, const DrawnSections& sections,
                    bool above, std::vector<LabelMove>& moves);
    std::optional<Region> region_beside(const std::vector<std::uint32_t>& component, Body body,
                                        bool is_inside) const;
    bool inside(std::uint32_t cell, std::uint32_t structure) const {
        return mesh_.registry.table().contains(mesh_.regions[cell], structure);
    }

    const RelabelledMesh& mesh_;
    std::vector<std::uint32_t> from_, queue_;  // scratch
};

}  // namespace anatomesh
