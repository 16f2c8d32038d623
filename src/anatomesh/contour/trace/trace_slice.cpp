#include "anatomesh/contour/trace/trace_slice.h"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace anatomesh {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
constexpr int junction = -1;  // Marks where more than two labels meet. [mark; negative; D]

// A cell of the dual grid lies between the four pixels corner[0] (x, y), [1] (x + 1, y), [2] (x + 1, y + 1)
// and [3] (x, y + 1). Its side s joins corner s with corner s + 1: bottom, right, top, left.
struct Cell {
    std::array<std::uint16_t, 4> corner;

    bool crossed(int side) const { return corner[side] != corner[(side + 1) & 3]; }
    int crossings() const { return crossed(0) + crossed(1) + crossed(2) + crossed(3); }

    // With four crossings: whether corners 0 and 2 (else 1 and 3) are joined; junction when neither are.
    int joined_diagonal() const {
        const bool equal02 = corner[0] == corner[2], equal13 = corner[1] == corner[3];
        if (!equal02 && !equal13) return junction;
        if (equal02 && equal13) return corner[0] < corner[1] ? 0 : 1;
        return equal02 ? 0 : 1;
    }

    bool is_junction() const {
        const int count = crossings();
        return count == 3 || (count == 4 && joined_diagonal() == junction);
    }

    // At a junction one label keeps the straight boundary that it would have if all others were one: the
    // outside, else the label of two corners. Returns the crossed side after its corners, or junction when
    // all four differ.
    int straight_side() const {
        for (int side = 0; side < 4; ++side) {
            if (corner[side] == 0 && crossed(side)) return side;
        }
        for (int side = 0; side < 4; ++side) {
            if (!crossed(side)) return (side + 1) & 3;
        }
        return junction;
    }

    // The side by which a boundary that enters by `side` leaves, or junction.
    int exit(int side) const {
        const int count = crossings();
        if (count == 2) {
            for (int other = 0; other < 4; ++other) {
                if (other != side && crossed(other)) return other;
            }
        }
        if (count == 3) return junction;
        const int diagonal = joined_diagonal();
        if (diagonal == junction) return junction;
        // Joining corners 0 and 2 cuts corner 1 (sides 0, 1) and corner 3 (sides 2, 3) off.
        return diagonal == 0 ? side ^ 1 : 3 - side;
    }
};

// A side of a cell, seen from the cell.
struct Gate {
    std::uint32_t x, y;
    int side;
};

class Tracer {
  public:
    Tracer(const LabelGrid& grid, const GreySlice& grey) : grid_(grid), grey_(grey) {}

    TracedGrid run() {
        find_crossings();
        place_points();
        walk_open_chains();
        walk_loops();
        assemble_rings();
        return std::move(traced_);
    }

  private:
    struct Crossing {
        std::uint32_t x, y;  // of the lower pixel
        bool vertical;       // to pixel (x, y + 1), else (x + 1, y)
    };
    struct Junction {
        std::uint32_t x, y;                                        // its cell
        std::array<std::uint32_t, 4> arm{none, none, none, none};  // outward directed chain per side
    };
    struct Sides {
        std::uint16_t left, right;
        std::uint32_t end_junction;  // none for a loop
        int end_side;
        std::uint32_t start_junction;
        int start_side;
    };

    Cell cell(std::uint32_t x, std::uint32_t y) const {
        const std::uint16_t* row = grid_.labels.data() + std::size_t{y} * grid_.row_length() + x;
        return {{row[0], row[1], row[grid_.row_length() + 1], row[grid_.row_length()]}};
    }

    std::uint32_t& slot(std::uint32_t x, std::uint32_t y, bool vertical) {
        return crossing_at_[2 * (std::size_t{y} * grid_.row_length() + x) + (vertical ? 1 : 0)];
    }

    std::uint32_t crossing(const Gate& gate) {
        switch (gate.side) {
            case 0:
                return slot(gate.x, gate.y, false);
            case 1:
                return slot(gate.x + 1, gate.y, true);
            case 2:
                return slot(gate.x, gate.y + 1, false);
            default:
                return slot(gate.x, gate.y, true);
        }
    }

    // The same crossing seen from the cell on its other side.
    static Gate across(const Gate& gate) {
        switch (gate.side) {
            case 0:
                return {gate.x, gate.y - 1, 2};
            case 1:
                return {gate.x + 1, gate.y, 3};
            case 2:
                return {gate.x, gate.y + 1, 0};
            default:
                return {gate.x - 1, gate.y, 1};
        }
    }

    void find_crossings() {
        const std::uint32_t length = grid_.row_length(), rows = grid_.height + 2;
        crossing_at_.assign(2 * grid_.labels.size(), none);
        for (std::uint32_t y = 0; y + 1 < rows; ++y) {
            const std::uint16_t* row = grid_.labels.data() + std::size_t{y} * length;
            for (std::uint32_t x = 0; x + 1 < length; ++x) {
                const bool right = row[x] != row[x + 1], up = row[x] != row[x + length];
                if (!right && !up) continue;
                if (right) add_crossing(x, y, false);
                if (up) add_crossing(x, y, true);
                if (cell(x, y).is_junction()) junctions_.push_back({x, y});
            }
        }
    }

    void add_crossing(std::uint32_t x, std::uint32_t y, bool vertical) {
        slot(x, y, vertical) = static_cast<std::uint32_t>(crossings_.size());
        crossings_.push_back({x, y, vertical});
    }

    // Where on the edge the boundary crosses, 0 at the lower pixel, 1 at the other.
    double share(const Crossing& c) const {
        const std::uint32_t x1 = c.x + (c.vertical ? 0 : 1), y1 = c.y + (c.vertical ? 1 : 0);
        if (!grey_.base || c.x == 0 || c.y == 0 || x1 > grid_.width || y1 > grid_.height) return 0.5;
        const double low = grey_value(c.x, c.y), high = grey_value(x1, y1), at = grey_.threshold;
        if (!((low < at && high >= at) || (low >= at && high < at))) return 0.5;
        const double t = (at - low) / (high - low);
        if (!(t >= 0 && t <= 1)) return 0.5;  // infinite values
        // Close to a pixel centre that another piece of boundary passes as well: stay clear of it.
        const double lower = t < pinch_share && pinched(c.x, c.y) ? pinch_share : least_share;
        const double upper = 1 - t < pinch_share && pinched(x1, y1) ? pinch_share : least_share;
        return t < lower ? lower : 1 - t < upper ? 1 - upper : t;
    }

    double grey_value(std::uint32_t x, std::uint32_t y) const {
        return grey_.base[(x - 1) * grey_.step_i + (y - 1) * grey_.step_j];
    }

    // Whether the crossed edges around pixel (x, y), which is no border pixel, belong to more than one piece
    // of boundary, or to one that closes around the pixel.
    bool pinched(std::uint32_t x, std::uint32_t y) const {
        // Counter-clockwise from the right: the cell after each edge, and the sides by which the edge and the
        // next one bound it.
        const std::uint16_t here = grid_.at(x, y);
        const int edges = (grid_.at(x + 1, y) != here) + (grid_.at(x, y + 1) != here) +
                          (grid_.at(x - 1, y) != here) + (grid_.at(x, y - 1) != here);
        int links = 0;
        links += linked(cell(x, y), 0, 3) + linked(cell(x - 1, y), 1, 0);
        links += linked(cell(x - 1, y - 1), 2, 1) + linked(cell(x, y - 1), 3, 2);
        return edges - links != 1;
    }

    static int linked(const Cell& between, int side, int other) {
        return between.crossed(side) && between.exit(side) == other ? 1 : 0;
    }

    void place_points() {
        std::vector<Vec2>& points = traced_.network.points;
        points.reserve(crossings_.size() + junctions_.size());
        for (const Crossing& c : crossings_) {
            // The border of the grid shifts pixel indices by one.
            const double x = c.x - 1.0, y = c.y - 1.0, t = share(c);
            points.push_back(c.vertical ? Vec2{x, y + t} : Vec2{x + t, y});
        }
        for (const Junction& j : junctions_) points.push_back(junction_point(j));
    }

    Vec2 junction_point(const Junction& j) {
        const std::vector<Vec2>& points = traced_.network.points;
        const Cell between = cell(j.x, j.y);
        const int straight = between.straight_side();
        if (straight != junction) {
            // The label's corners lie between this crossed side and the last one before it, clockwise.
            int other = straight;
            do other = (other + 3) & 3;
            while (!between.crossed(other));
            return 0.5 * (points[crossing({j.x, j.y, straight})] + points[crossing({j.x, j.y, other})]);
        }
        Vec2 sum;
        for (int side = 0; side < 4; ++side) sum = sum + points[crossing({j.x, j.y, side})];
        return 0.25 * sum;
    }

    // Follows the boundary out of a cell until it meets a junction or `stop`. Appends the points.
    // Returns the gate of the last cell by which it was entered.
    Gate follow(Gate out, std::uint32_t stop) {
        while (true) {
            const std::uint32_t at = crossing(out);
            traced_.network.chain_points.push_back(at);
            visited_[at] = 1;
            const Gate in = across(out);
            const int side = cell(in.x, in.y).exit(in.side);
            if (side == junction) return in;
            out = {in.x, in.y, side};
            if (crossing(out) == stop) return in;
        }
    }

    Sides sides_of(const Gate& out) const {
        const Cell from = cell(out.x, out.y);
        return {from.corner[(out.side + 1) & 3], from.corner[out.side], none, 0, none, 0};
    }

    void walk_open_chains() {
        visited_.assign(crossings_.size(), 0);
        const auto first_junction = static_cast<std::uint32_t>(crossings_.size());
        for (std::uint32_t i = 0; i < junctions_.size(); ++i) {
            const Cell start = cell(junctions_[i].x, junctions_[i].y);
            for (int side = 0; side < 4; ++side) {
                const Gate out{junctions_[i].x, junctions_[i].y, side};
                if (!start.crossed(side) || visited_[crossing(out)]) continue;
                Sides sides = sides_of(out);
                sides.start_junction = i;
                sides.start_side = side;
                traced_.network.chain_points.push_back(first_junction + i);
                const Gate in = follow(out, none);
                sides.end_junction = junction_index(in);
                sides.end_side = in.side;
                traced_.network.chain_points.push_back(first_junction + sides.end_junction);
                close_chain(sides);
            }
        }
    }

    // Junctions were found in the order of rows and columns: binary search.
    std::uint32_t junction_index(const Gate& in) const {
        std::uint32_t low = 0, high = static_cast<std::uint32_t>(junctions_.size());
        while (high - low > 1) {
            const std::uint32_t middle = (low + high) / 2;
            const Junction& j = junctions_[middle];
            const bool after = j.y > in.y || (j.y == in.y && j.x > in.x);
            (after ? high : low) = middle;
        }
        return low;
    }

    void close_chain(const Sides& sides) {
        const auto chain = static_cast<std::uint32_t>(sides_.size());
        if (sides.end_junction != none) {
            junctions_[sides.start_junction].arm[sides.start_side] = 2 * chain;
            junctions_[sides.end_junction].arm[sides.end_side] = 2 * chain + 1;
        }
        sides_.push_back(sides);
        traced_.network.close_chain(sides.end_junction != none);
    }

    void walk_loops() {
        for (std::uint32_t i = 0; i < crossings_.size(); ++i) {
            if (visited_[i]) continue;
            const Crossing& c = crossings_[i];
            const Gate out = c.vertical ? Gate{c.x, c.y, 3} : Gate{c.x, c.y, 0};
            const Sides sides = sides_of(out);
            follow(out, i);
            traced_.network.chain_points.push_back(i);
            close_chain(sides);
        }
    }

    // At its end a ring goes on with the next arm clockwise: the label lies between the two.
    std::uint32_t following(std::uint32_t link) const {
        const Sides& sides = sides_[link / 2];
        const bool backwards = link & 1;
        const Junction& j = junctions_[backwards ? sides.start_junction : sides.end_junction];
        int side = backwards ? sides.start_side : sides.end_side;
        do side = (side + 3) & 3;
        while (j.arm[side] == none);
        return j.arm[side];
    }

    std::uint16_t label_of(std::uint32_t link) const {
        return link & 1 ? sides_[link / 2].right : sides_[link / 2].left;
    }

    void assemble_rings() {
        std::vector<std::uint8_t> used(2 * sides_.size(), 0);
        for (std::uint32_t start = 0; start < used.size(); ++start) {
            if (used[start]) continue;
            TracedRing ring{label_of(start), static_cast<std::uint32_t>(traced_.links.size()), 0, 0};
            std::uint32_t link = start;
            do {
                assert(!used[link] && label_of(link) == ring.label);
                used[link] = 1;
                traced_.links.push_back(link);
                ++ring.count;
                if (sides_[link / 2].end_junction == none) break;
                link = following(link);
            } while (link != start);
            ring.pixels = pixels_inside(ring);
            (ring.label == 0 ? traced_.outside : traced_.rings).push_back(ring);
        }
    }

    // The area of the polygon of the cells that the ring passes: pixel corners, along the pixels' own edges.
    std::int64_t pixels_inside(const TracedRing& ring) {
        ring_points_.clear();
        append_ring_points(traced_, ring, ring_points_);
        const auto cell_after = [&](std::size_t i) {
            // Between two points that follow each other lies the cell that both are on the border of or inside.
            const Vec2 middle = 0.5 * (traced_.network.points[ring_points_[i]] +
                                       traced_.network.points[ring_points_[(i + 1) % ring_points_.size()]]);
            return std::pair(static_cast<std::int64_t>(std::floor(middle.x)),
                             static_cast<std::int64_t>(std::floor(middle.y)));
        };
        std::int64_t twice = 0;
        auto last = cell_after(ring_points_.size() - 1);
        for (std::size_t i = 0; i < ring_points_.size(); ++i) {
            const auto next = cell_after(i);
            twice += last.first * next.second - next.first * last.second;
            last = next;
        }
        return twice / 2;
    }

    // A crossing keeps this share of the way between two pixel centres from each. [1; 0 to 0.5; D a choice, measurement not recorded]
    static constexpr double least_share = 1.0 / 64;
    // And this one from a centre that another piece of boundary passes as well. [1; 0 to 0.5; D a choice, measurement not recorded]
    static constexpr double pinch_share = 0.15;

    const LabelGrid& grid_;
    const GreySlice& grey_;
    TracedGrid traced_;
    std::vector<Crossing> crossings_;
    std::vector<std::uint32_t> crossing_at_;  // per pixel: of the edge to the right, of the edge up
    std::vector<Junction> junctions_;
    std::vector<std::uint8_t> visited_;  // per crossing
    std::vector<Sides> sides_;           // per chain
    std::vector<std::uint32_t> ring_points_;
};

}  // namespace

TracedGrid trace_label_grid(const LabelGrid& grid, const GreySlice& grey) {
    return Tracer(grid, grey).run();
}

void append_ring_points(const TracedGrid& traced, const TracedRing& ring,
                        std::vector<std::uint32_t>& points) {
    for (std::uint32_t i = ring.first; i < ring.first + ring.count; ++i) {
        const std::span<const std::uint32_t> chain = traced.network.chain(traced.links[i] / 2);
        // The last point of a chain is the first of the next one.
        if (traced.links[i] & 1) {
            for (std::size_t k = chain.size(); k-- > 1;) points.push_back(chain[k]);
        } else {
            points.insert(points.end(), chain.begin(), chain.end() - 1);
        }
    }
}

}  // namespace anatomesh
