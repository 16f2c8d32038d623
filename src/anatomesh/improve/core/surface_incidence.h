// SurfaceIncidence: what the mesh has at edges and vertices, seen from one structure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// Uses the context's ring and star. An edge or a vertex is on a structure's surface where cells of both sides
// are round it.
class SurfaceIncidence {
  public:
    explicit SurfaceIncidence(EditContext& edit) : edit_(edit) {}

    bool has(std::uint32_t c, std::uint32_t structure) const {
        return edit_.table->contains(edit_.mesh.region(c), structure);
    }
    // Finds the cells round an edge, for the context's ring; false where it is none, or on the hull.
    bool find_ring(std::uint32_t a, std::uint32_t b);
    // Whether cells of both sides of the structure are in the context's ring.
    bool ring_is_mixed(std::uint32_t structure) const { return is_mixed(edit_.ring.cells, structure); }

    bool on_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
        return find_ring(a, b) && ring_is_mixed(structure);
    }
    bool on_surface(std::uint32_t v, std::uint32_t structure) {
        edit_.mesh.star(v, edit_.star);
        return is_mixed(edit_.star, structure);
    }
    // Whether an edge has cells of one side alone round it.
    bool beside_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure) {
        return find_ring(a, b) && !ring_is_mixed(structure);
    }
    // The vertices on the straight way from one vertex to another that edges of the surface join, from the
    // first on, as far as they go.
    std::vector<std::uint32_t> row_from(std::uint32_t first, std::uint32_t last, std::uint32_t structure);
    // How far a step leads on along a way, times its length, if it lies on it within a millionth.
    static std::optional<double> onward(Vec3 step, Vec3 way);
    // Whether a chain of subsegments lies on the surface, each as an edge or as the edges that it was split
    // into.
    bool on_surface(std::span<const std::uint32_t> chain, std::uint32_t structure);

  private:
    bool row_on_surface(std::uint32_t a, std::uint32_t b, std::uint32_t structure);
    std::uint32_t next_in_row(std::uint32_t at, std::uint32_t a, std::uint32_t b);
    std::uint32_t next_on_surface(std::uint32_t at, std::uint32_t first, std::uint32_t last,
                                  std::uint32_t structure);
    bool is_mixed(const std::vector<std::uint32_t>& cells, std::uint32_t structure) const;

    EditContext& edit_;
};

}  // namespace anatomesh
