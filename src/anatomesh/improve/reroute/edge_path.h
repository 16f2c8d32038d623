// EdgePathSearch: the way over edges of a surface that keeps nearest to a stretch of a contour.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "anatomesh/geom/plane.h"
#include "anatomesh/mesh/model/surface_graph.h"
#include "anatomesh/mesh/model/tet_mesh.h"

namespace anatomesh {

// Over what edges a way may lead.
enum class EdgePathRule : std::uint8_t {
    all,
    onwards,  // that lead on along the stretch: such a way crosses itself nowhere
    clear     // that cross no segment beside it, and backwards at a high price: it may cross itself
};

class EdgePathSearch {
  public:
    using Segment = std::array<std::uint32_t, 2>;  // its vertices

    // `plane`: of the slice. Requires: all outlive this.
    EdgePathSearch(std::span<const Vec3> points, const SurfaceGraph& graph, const Plane& plane,
                   double most_mm)
        : points_(points), graph_(graph), plane_(plane), most_mm_(most_mm) {}

    // The next ways replace this row of vertices.
    void begin(std::vector<std::uint32_t> stretch);
    const std::vector<std::uint32_t>& stretch() const { return stretch_; }

    // The way with the least integral of the distance from the stretch, which is nowhere above `most_mm`,
    // over vertices that `may_pass`; without its ends. `beside`: segments that it must not cross, seen along
    // the plane's normal, by the rule `clear`. Nothing, if there is none among 20,000 vertices. Complexity:
    // O(n log n) in the vertices within `most_mm`. Follows: Dijkstra, Numer. Math. 1, 1959.
    std::optional<std::vector<std::uint32_t>> find(EdgePathRule rule, std::span<const Segment> beside,
                                                   const std::function<bool(std::uint32_t)>& may_pass);
    // Whether the row from end to end of the stretch over these vertices is edges.
    bool are_edges(std::span<const std::uint32_t> between) const;
    // The larger of the distances of that row's vertices from the stretch, and of those from it.
    double farthest(std::span<const std::uint32_t> between) const;

  private:
    struct Reached {
        double distance = 0;  // from the stretch
        double price = HUGE_VAL;
        std::uint32_t from = no_cell;
        bool is_done = false;
    };
    bool reach_end(EdgePathRule rule, std::span<const Segment> beside,
                   const std::function<bool(std::uint32_t)>& may_pass);
    bool crosses_any(std::uint32_t v, std::uint32_t w, std::span<const Segment> beside) const;
    double distance_from_stretch(std::uint32_t v) const;
    std::vector<Vec3> places(std::span<const std::uint32_t> vertices) const;
    Vec2 at(std::uint32_t v) const { return plane_.to_plane(points_[v]); }

    std::span<const Vec3> points_;
    const SurfaceGraph& graph_;
    const Plane& plane_;
    double most_mm_;
    std::vector<std::uint32_t> stretch_;
    std::vector<Vec3> stretch_places_;
    std::unordered_map<std::uint32_t, Reached> reached_;
};

}  // namespace anatomesh
