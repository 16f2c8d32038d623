// DistanceMap: signed Euclidean distance to the drawn region of one structure in one slice.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/field/slice/scanline.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

// The distance map DM of Archip et al. (2006), but exact: the distance is to the polygon itself, not to voxel
// centres. Negative inside, positive outside, clamped to +-limit. Immutable; queries are const and
// thread-safe.
//
// A grid of cells covers the region's box and a margin of `limit`. Each cell within reach of the boundary
// lists every edge that can be the nearest one to any of its points: if d is the distance of the nearest edge
// from the cell's centre and r the cell's half diagonal, those within d + 2 r of the centre. A query looks at
// these alone. Lists of more than 64 edges become lists of strips: 16 edges that follow one another, or 16
// such strips, each with the segment from its first vertex to its last and how far it strays from that; a
// query opens those that can hold the nearest edge (strip trees: Ballard, Commun. ACM 24, 1981). In cells
// that the boundary does not cross the sign is that of the centre, found by scanline; in the others it is
// found from the nearest edge or vertex by exact orientation.
//
// Guarantees: the value is 0 at every vertex; its sign is that of the even-odd region in exact arithmetic on
// the coordinates as given; its size is the Euclidean distance within a few roundings. Complexity:
// construction O(n log n) in the edges and linear in the cells, whose number is linear in n; a query O(1) for
// contours with bounded curvature and edges about as long as the cells, O(log n) for finer ones.
class DistanceMap {
  public:
    // Requires: the edges bound a region, closed and without crossings, region on the left; limit > 0.
    // `cell` is the grid's cell size; 0: from the edges' mean length and `limit`.
    DistanceMap(std::vector<Edge2> edges, double limit, double cell = 0);

    double value(Vec2 q) const { return value(q, place(q)); }

    // What the grid alone knows of value(q): its sign, 0 near the boundary, where that takes a measurement,
    // and a number that its size is not below.
    struct Bound {
        int sign;
        double at_least;
    };
    Bound bound(Vec2 q) const { return bound(place(q)); }

    // value(q); where the grid alone tells that its size is above `reach`, a number of the same sign above
    // it.
    double value_within(Vec2 q, double reach) const {
        const std::uint32_t entry = place(q);
        const Bound known = bound(entry);
        return known.sign != 0 && known.at_least > reach ? known.sign * known.at_least : value(q, entry);
    }

    // The same in two steps: whoever asks several maps finds all places first, so that the accesses to memory
    // overlap.
    std::uint32_t place(Vec2 q) const {
        const double x = (q.x - box_.low.x) * grid_.inverse, y = (q.y - box_.low.y) * grid_.inverse;
        if (!(x >= 0 && y >= 0 && x < grid_.nx && y < grid_.ny)) return far_outside;
        return cells_[static_cast<std::size_t>(static_cast<std::uint32_t>(y)) * grid_.nx +
                      static_cast<std::uint32_t>(x)];
    }
    void prefetch(std::uint32_t entry) const { __builtin_prefetch(candidates_.data() + entry); }
    void prefetch_edges(std::uint32_t entry) const {  // waits for what prefetch() asked for
        if (entry >= first_list) __builtin_prefetch(lines_.data() + candidates_[entry + head_size]);
    }
    double value(Vec2 q, std::uint32_t entry) const {
        if (entry < first_list) return entry == far_inside ? -limit_ : limit_;
        return near_value(q, entry);
    }
    Bound bound(std::uint32_t entry) const {
        if (entry < first_list) return {entry == far_inside ? -1 : 1, limit_};
        const Side whole = head_at(entry).side();
        if (whole == crossed) return {0, 0};
        return {whole == all_inside ? -1 : 1, std::bit_cast<float>(candidates_[entry + 1])};
    }

    // Beyond this box the value is +limit.
    const Box2& box() const { return box_; }
    const Box2& region_box() const { return region_box_; }
    double limit() const { return limit_; }
    double area() const { return area_; }  // of the drawn region, mm^2
    double cell() const { return grid_.cell; }
    std::span<const Edge2> edges() const { return edges_; }
    std::size_t bytes() const;
    // How many edges and strips value(q) looks at.
    std::size_t steps(Vec2 q) const;

  private:
    // Entries of cells_ below first_list: no edge within the limit of any point of the cell.
    enum Entry : std::uint32_t { far_outside = 0, far_inside = 1, first_list = 2 };

    // Whether the boundary crosses a cell or leaves it on one side.
    enum Side : std::uint32_t { crossed = 0, all_outside = 1, all_inside = 2 };

    // What a list begins with, in 32 bits: how many entries, of which level (below 4), and the cell's side.
    struct ListHead {
        std::uint32_t bits;
        Side side() const { return static_cast<Side>(bits & 3u); }
        std::uint32_t level() const { return bits >> 2 & 3u; }
        std::uint32_t count() const { return bits >> 4; }
        static ListHead of(std::size_t count, std::uint32_t level, std::uint32_t side) {
            return {static_cast<std::uint32_t>(count) << 4 | level << 2 | side};
        }
    };
    // Before the entries of a list: its head, and the bits of a float. [words; 2; D]
    static constexpr std::uint32_t head_size = 2;

    // Square cells from the box's lower corner on.
    struct Grid {
        double cell = 0, inverse = 0;  // edge of a cell
        std::uint32_t nx = 0, ny = 0;  // how many cells
        std::size_t size() const { return static_cast<std::size_t>(nx) * ny; }
    };

    // What the region looks like at an end of an edge: which side is near when the end is the nearest
    // feature.
    enum class Corner : std::uint8_t { convex, reflex, straight, shared };

    struct Line {                         // an edge made ready for distances
        Vec2 start, along;                // from there to the end
        double squared = 0, inverse = 0;  // of the length
    };
    struct Strip {  // edges that follow one another, all within `reach` of the chord
        Line chord;
        Vec2 end;
        double reach;
    };
    struct List {  // edges on level 0, strips above
        std::span<const std::uint32_t> entries;
        std::uint32_t level;
        std::uint32_t operator()(std::size_t i) const { return entries[i]; }
    };
    struct Run {  // the edges or strips of one strip
        std::size_t first;
        std::uint32_t operator()(std::size_t i) const { return static_cast<std::uint32_t>(first + i); }
    };
    struct Nearest {
        double squared, second;  // the least distance, and the next
        std::uint32_t edge;
        std::size_t steps = 0;  // edges and strips looked at
    };
    struct Foot {
        double squared_distance;
        int end;  // -1: start, +1: end, 0: between
    };

    void classify_corners();
    void choose_grid(double cell);
    PixelGrid centres() const {
        const double cell = grid_.cell;
        return {box_.low + Vec2{0.5 * cell, 0.5 * cell}, {cell, cell}, grid_.nx, grid_.ny};
    }
    static void squared_distances(const Line& line, std::span<const double> x, double y, double* squared);
    template <class Body>
    void each_cell_near_an_edge(Body body) const;
    void list_candidates();
    void make_strips();
    Strip make_strip(std::size_t first, std::size_t last) const;
    void shorten_lists();
    ListHead head_at(std::uint32_t entry) const { return {candidates_[entry]}; }
    List list_at(std::uint32_t entry) const;
    double near_value(Vec2 q, std::uint32_t entry) const;
    double value_by_strips(Vec2 q, std::uint32_t entry) const;
    double signed_value(Vec2 q, std::uint32_t entry, const Nearest& nearest) const;
    double padded(double distance) const { return distance * (1 + 1e-12) + 2 * tie_; }
    template <class At, class Body>
    std::size_t each_near(Vec2 q, std::uint32_t level, std::size_t count, At at, double& bound,
                          const Body& body) const;
    Nearest nearest_by_strips(Vec2 q, const List& list, double bound) const;
    bool is_never_nearest(const Line& line, Vec2 centre, const Line& best) const;
    Vec2 nearest_point(const Line& line, Vec2 q) const;
    // In the line's own frame, without a branch: across it, and along it beyond the nearer end. Exactly 0
    // where q is one of the ends.
    static Foot foot(const Line& line, Vec2 q) {
        const Vec2 w = q - line.start;
        const double projection = dot(w, line.along), across = cross(line.along, w);
        const double beyond = projection - std::min(std::max(projection, 0.0), line.squared);
        return {(across * across + beyond * beyond) * line.inverse,
                (projection >= line.squared) - (projection <= 0)};
    }
    int side(std::uint32_t edge, int end, Vec2 q) const;
    int side_by_parity(Vec2 q) const;
    template <class Body>
    void each_beside(Vec2 q, const Body& body) const;
    int side_of_nearest(Vec2 q, const List& list, double tied) const;

    std::vector<Edge2> edges_;
    std::vector<Line> lines_;
    std::vector<Corner> start_corner_, end_corner_;
    Box2 region_box_, box_;
    double limit_ = 0, area_ = 0, tie_ = 0;
    Grid grid_;
    std::vector<std::uint32_t> cells_;  // far_outside, far_inside, or where in candidates_ the list starts
    // Per list: its head, a lower bound of the distance (a float's bits), then the edges or strips, rising.
    std::vector<std::uint32_t> candidates_;
    std::vector<std::vector<Strip>> strips_;  // by level, from 1 on; none where no list is long
};

}  // namespace anatomesh
