// SurfaceCount: what the surfaces of structures and regions are at a few cells that are to change their
// region.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/mesh/stars/star.h"

namespace anatomesh {

class SurfaceCount {
  public:
    // `cells` are to be relabelled to the region `to`. Requires: context and owners outlive this.
    SurfaceCount(EditContext& edit, const ContourOwners& owners, std::span<const std::uint32_t> cells,
                 Region to);

    struct Figures {
        int excess = 0;  // components too many of the stars of the cells' vertices, over all bodies
        std::vector<int> characteristics;  // by body: vertices - edges + facets of its surface, of the cells'
    };
    Figures figures();

    // The characteristics of whole structures. Regions make walls, which may have any number of components.
    std::span<const int> of_structures(const Figures& figures) const;

    // These, one for each figure of them.
    const std::vector<std::uint32_t>& structures() const { return structures_; }

    // Contour vertices and subsegments on their surface when the object was made, and not any more.
    std::size_t newly_lost();

  private:
    struct Edge {
        std::uint32_t a, b, cell;
        int index;
    };
    struct Owned {
        std::uint32_t a, b, cell, structure;  // of a vertex: a == b
        int index;                            // of the edge in the cell
    };
    bool holds(const Body& body, std::uint32_t c) const {
        return body.holds(*edit_.table, edit_.mesh.region(c));
    }
    bool mixed(const Body& body, const std::vector<std::uint32_t>& cells) const;
    int excess_at(std::uint32_t v);
    int components(const Body& body, bool inside);
    bool on_surface(const Owned& owned);
    int characteristic(const Body& body);

    EditContext& edit_;
    std::vector<std::uint32_t> cells_;
    std::vector<Body> bodies_;  // regions, then structures
    std::vector<std::uint32_t> structures_;
    std::size_t region_bodies_ = 0;  // of these
    std::vector<std::uint32_t> vertices_;
    std::vector<Edge> edges_;
    std::vector<Owned> owned_;
    std::vector<std::uint32_t> star_, stack_;
    std::vector<std::array<std::uint32_t, 3>> across_;  // by cell of the star: positions
    std::vector<std::uint8_t> seen_;
};

}  // namespace anatomesh
