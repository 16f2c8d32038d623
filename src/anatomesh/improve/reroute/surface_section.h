// SurfaceSection: where a plane cuts the surface of one structure, as ways over its facets.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "anatomesh/geom/plane.h"
#include "anatomesh/improve/core/surface_incidence.h"

namespace anatomesh {

// A vertex of the surface in the plane (q: no_cell), or where the plane cuts one of its edges (p < q).
struct SectionNode {
    std::uint32_t p = no_cell, q = no_cell;
    bool is_vertex() const { return q == no_cell; }
    friend auto operator<=>(const SectionNode&, const SectionNode&) = default;
};

struct SectionPoint {
    SectionNode node;
    Vec3 place;
};

// A vertex where a way may begin or end, at a price that counts like its length. >= 0, mm
struct WayEnd {
    std::uint32_t vertex = 0;
    double price = 0;
};

class SurfaceSection {
  public:
    // Vertices within `in_plane_mm` of the plane, and `in_plane` (rising) however far from it, lie in it.
    // Requires: all outlive this. Uses the context's ring and star.
    SurfaceSection(EditContext& edit, const Plane& plane, std::uint32_t structure, double in_plane_mm,
                   std::span<const std::uint32_t> in_plane);

    // The shortest way from one of `starts` to one of `ends`, both included, over points that are allowed; it
    // passes no other start or end. Nothing, if there is none among the 20,000 points nearest to the starts.
    // Complexity: O(points seen x log), and the stars of those that are vertices. Follows: Dijkstra, Numer.
    // Math. 1, 1959.
    std::optional<std::vector<SectionPoint>> shortest_way(
        std::span<const WayEnd> starts, std::span<const WayEnd> ends,
        const std::function<bool(const SectionPoint&)>& allowed);

  private:
    int side(std::uint32_t v) const;
    Vec3 place(const SectionNode& node) const;
    void beside(const SectionNode& node, std::vector<SectionNode>& found);
    void add_facets_at(std::uint32_t c, std::uint32_t v, std::vector<SectionNode>& found) const;
    void add_across(const SectionNode& node, std::uint32_t r, std::vector<SectionNode>& found) const;

    EditContext& edit_;
    const Plane& plane_;
    std::uint32_t structure_;
    SurfaceIncidence incidence_;
    double in_plane_mm_;
    std::span<const std::uint32_t> in_plane_;
};

}  // namespace anatomesh
