#include "anatomesh/field/slice_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <tuple>
#include <utility>

namespace anatomesh {

namespace {

// All in gaps between the two slices.
constexpr double piece_length = 0.5;  // longer edges are matched in pieces
constexpr double facing_reach = 0.5;  // a piece faces across the chord this far along the boundary both ways
constexpr double search_reach = 3.5;  // no boundary moves further
constexpr double turn_cost = 0.5;  // a match that turns by a right angle costs as much as one this far away
constexpr double return_tolerance = 0.5;  // a match that leads back this far from its start counts half
constexpr double rest = 0.1;              // length of unmoved boundary that every average contains
constexpr double lattice_step = 0.5;
constexpr std::array<double, 3> averaging{4.4, 2.8, 1.8};  // radius of the neighbourhood, round by round
constexpr std::uint32_t most_columns = 12;  // of a lattice within a radius, which is four steps at most
constexpr double least_cosine = 0.3;                       // pieces that face further apart are never matched
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

// A stretch of a boundary.
struct Piece {
    Vec2 a, b, facing;  // facing: unit vector out of the region
    double length = 0;
    Vec2 middle() const { return 0.5 * (a + b); }
};

struct Boundary {
    std::vector<Piece> pieces;
    std::vector<std::uint32_t> next, previous;  // along the boundary; none where it cannot be told
};

// The edge that starts where each edge ends; where several do, the first that is not taken yet.
std::vector<std::uint32_t> following(std::span<const Edge2> edges) {
    const auto key = [](Vec2 p) { return std::pair(p.x, p.y); };
    std::vector<std::uint32_t> by_start(edges.size()), next(edges.size(), none);
    for (std::uint32_t e = 0; e < edges.size(); ++e) by_start[e] = e;
    std::sort(by_start.begin(), by_start.end(), [&](std::uint32_t i, std::uint32_t j) {
        return std::tuple(key(edges[i].a), i) < std::tuple(key(edges[j].a), j);
    });
    std::vector<bool> taken(edges.size(), false);
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        auto at = std::lower_bound(by_start.begin(), by_start.end(), key(edges[e].b),
                                   [&](std::uint32_t i, const auto& k) { return key(edges[i].a) < k; });
        while (at != by_start.end() && taken[*at]) ++at;
        if (at == by_start.end() || !(edges[*at].a == edges[e].b)) continue;
        next[e] = *at;
        taken[*at] = true;
    }
    return next;
}

// The point `reach` along the boundary from the middle of piece p, with `step` from piece to piece.
Vec2 along(const Boundary& boundary, std::uint32_t p, const std::vector<std::uint32_t>& step, bool forward,
           double reach) {
    const auto far_end = [&](const Piece& piece) { return forward ? piece.b : piece.a; };
    Vec2 from = boundary.pieces[p].middle();
    std::uint32_t at = p;
    double left = reach;
    while (true) {
        const Vec2 to = far_end(boundary.pieces[at]);
        const double distance = length(to - from);
        if (distance >= left) return from + (left / distance) * (to - from);
        left -= distance;
        from = to;
        at = step[at];
        if (at == none || at == p) return from;
    }
}

Boundary boundary_of(const DistanceMap& map, double gap) {
    Boundary boundary;
    const std::span<const Edge2> edges = map.edges();
    const std::vector<std::uint32_t> next_edge = following(edges);
    std::vector<std::uint32_t> first(edges.size() + 1, 0);
    double perimeter = 0;
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        const Vec2 edge = edges[e].b - edges[e].a;
        const double size = length(edge);
        const auto count =
            static_cast<std::uint32_t>(std::clamp(std::ceil(size / (piece_length * gap) - 1e-6), 1.0, 1e4));
        for (std::uint32_t i = 0; i < count; ++i) {
            const double s = static_cast<double>(i) / count, t = static_cast<double>(i + 1) / count;
            boundary.pieces.push_back({edges[e].a + s * edge,
                                       i + 1 == count ? edges[e].b : edges[e].a + t * edge,
                                       (1 / size) * Vec2{edge.y, -edge.x}, size / count});
        }
        first[e + 1] = first[e] + count;
        perimeter += size;
    }
    boundary.next.assign(boundary.pieces.size(), none);
    boundary.previous.assign(boundary.pieces.size(), none);
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        for (std::uint32_t p = first[e]; p < first[e + 1]; ++p) {
            boundary.next[p] = p + 1 < first[e + 1]   ? p + 1
                               : next_edge[e] == none ? none
                                                      : first[next_edge[e]];
            if (boundary.next[p] != none) boundary.previous[boundary.next[p]] = p;
        }
    }
    for (std::uint32_t p = 0; p < boundary.pieces.size(); ++p) {
        const double reach = std::min(facing_reach * gap, 0.125 * perimeter);
        const Vec2 chord = along(boundary, p, boundary.next, true, reach) -
                           along(boundary, p, boundary.previous, false, reach);
        const double size = length(chord);
        if (size > 0.1 * reach) boundary.pieces[p].facing = (1 / size) * Vec2{chord.y, -chord.x};
    }
    return boundary;
}

// The pieces of a boundary in square bins, to search round a point.
class PieceIndex {
  public:
    PieceIndex(const Boundary& boundary, double gap) : pieces_(boundary.pieces), gap_(gap) {
        for (const Piece& piece : pieces_) box_.extend(piece.middle());
        // Never many more bins than pieces, however large the region.
        const Vec2 size = box_.high - box_.low;
        const double most = 4.0 * static_cast<double>(pieces_.size()) + 64;
        bin_ = std::max({0.5 * gap, std::sqrt(size.x * size.y / most), std::max(size.x, size.y) / most});
        nx_ = static_cast<std::int64_t>(size.x / bin_) + 1;
        ny_ = static_cast<std::int64_t>(size.y / bin_) + 1;
        begin_.assign(static_cast<std::size_t>(nx_ * ny_) + 1, 0);
        for (const Piece& piece : pieces_) ++begin_[bin_of(piece.middle()) + 1];
        for (std::size_t b = 1; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
        std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
        listed_.resize(pieces_.size());
        for (std::uint32_t p = 0; p < pieces_.size(); ++p) {
            const Piece& piece = pieces_[p];
            const Vec2 edge = piece.b - piece.a;
            listed_[next[bin_of(piece.middle())]++] = {piece.a, edge, piece.facing, 1 / squared_length(edge), p};
        }
    }

    struct Match {
        std::uint32_t piece = none;
        Vec2 point;
    };

    // The point of the boundary for one at `from` that faces `facing` and is expected at `target`: the
    // nearest to the target, a difference of facing counting as distance, within the search's reach of both.
    Match nearest(Vec2 from, Vec2 facing, Vec2 target) const {
        Match best;
        const double most = search_reach * gap_, turn = 2 * turn_cost * turn_cost * gap_ * gap_;
        double best_cost = most * most;
        const auto compare = [&](const Listed& piece) {
            const double cosine = dot(piece.facing, facing);
            if (cosine < least_cosine) return;
            const double s = std::clamp(dot(target - piece.a, piece.edge) * piece.inverse, 0.0, 1.0);
            const Vec2 point = piece.a + s * piece.edge;
            const double cost = squared_length(point - target) + turn * (1 - cosine);
            if (cost < best_cost && squared_length(point - from) < most * most) {
                best_cost = cost;
                best = {piece.number, point};
            }
        };
        // The target's bin and those round it, then ring by ring until the next is too far away.
        const std::int64_t ci = column(target.x, box_.low.x), cj = column(target.y, box_.low.y);
        for (std::int64_t j = cj - 1; j <= cj + 1; ++j) each_in_row(j, ci - 1, ci + 1, compare);
        const auto last = static_cast<std::int64_t>((most + 0.5 * piece_length * gap_) / bin_) + 1;
        for (std::int64_t ring = 2; ring <= last; ++ring) {
            const double nearest_possible = static_cast<double>(ring - 1) * bin_ - 0.5 * piece_length * gap_;
            if (nearest_possible > 0 && nearest_possible * nearest_possible > best_cost) break;
            each_in_row(cj - ring, ci - ring, ci + ring, compare);
            for (std::int64_t j = cj - ring + 1; j < cj + ring; ++j) {
                each_in_row(j, ci - ring, ci - ring, compare);
                each_in_row(j, ci + ring, ci + ring, compare);
            }
            each_in_row(cj + ring, ci - ring, ci + ring, compare);
        }
        return best;
    }

  private:
    std::int64_t column(double x, double low) const {
        return static_cast<std::int64_t>(std::floor((x - low) / bin_));
    }
    std::size_t bin_of(Vec2 q) const {
        const std::int64_t i = std::clamp<std::int64_t>(column(q.x, box_.low.x), 0, nx_ - 1);
        const std::int64_t j = std::clamp<std::int64_t>(column(q.y, box_.low.y), 0, ny_ - 1);
        return static_cast<std::size_t>(j * nx_ + i);
    }
    // The pieces in the bins from `first` to `last` of row j, which lie together.
    template <class Body>
    void each_in_row(std::int64_t j, std::int64_t first, std::int64_t last, const Body& body) const {
        if (j < 0 || j >= ny_ || first >= nx_ || last < 0) return;
        const auto row = static_cast<std::size_t>(j * nx_);
        const std::uint32_t end = begin_[row + static_cast<std::size_t>(std::min(last, nx_ - 1)) + 1];
        for (std::uint32_t l = begin_[row + static_cast<std::size_t>(std::max<std::int64_t>(first, 0))];
             l < end; ++l) {
            body(listed_[l]);
        }
    }

    // A piece made ready for the search; those of a bin lie together.
    struct Listed {
        Vec2 a, edge, facing;
        double inverse;  // of the squared length
        std::uint32_t number;
    };
    const std::vector<Piece>& pieces_;
    double gap_, bin_ = 1;
    Box2 box_;
    std::int64_t nx_ = 1, ny_ = 1;
    std::vector<std::uint32_t> begin_;
    std::vector<Listed> listed_;
};

// Nodes at multiples of `step` that cover a box. `most` bounds their number.
struct Lattice {
    Vec2 low;
    double step = 1;
    std::uint32_t nx = 0, ny = 0;

    Lattice(const Box2& box, double wanted, double most) {
        const Vec2 size = box.high - box.low;
        step = std::max({wanted, std::sqrt(size.x * size.y / most), std::max(size.x, size.y) / most});
        low = {std::floor(box.low.x / step) * step, std::floor(box.low.y / step) * step};
        nx = static_cast<std::uint32_t>((box.high.x - low.x) / step) + 2;
        ny = static_cast<std::uint32_t>((box.high.y - low.y) / step) + 2;
    }
    Vec2 node(std::uint32_t i, std::uint32_t j) const { return low + step * Vec2{double(i), double(j)}; }
    std::size_t count() const { return static_cast<std::size_t>(nx) * ny; }
};

// The mean of weighted vectors within a radius of every node, and of `at_rest` of no motion.
class Average {
  public:
    Average(const Lattice& lattice, double radius, double at_rest)
        : lattice_(lattice), radius_(radius), at_rest_(at_rest), sums_(lattice.count()) {}

    void add(Vec2 middle, Vec2 move, double weight) {
        const auto index = [&](double x, double low, std::uint32_t n) {
            return static_cast<std::uint32_t>(std::clamp((x - low) / lattice_.step, 0.0, n - 1.0));
        };
        const std::uint32_t i0 = index(middle.x - radius_, lattice_.low.x, lattice_.nx),
                            i1 = index(middle.x + radius_, lattice_.low.x, lattice_.nx),
                            j0 = index(middle.y - radius_, lattice_.low.y, lattice_.ny),
                            j1 = index(middle.y + radius_, lattice_.low.y, lattice_.ny);
        const double inverse = 1 / (radius_ * radius_);
        std::array<double, most_columns> across;  // squared distances of the columns
        assert(i1 - i0 < most_columns);
        for (std::uint32_t i = i0; i <= i1; ++i) {
            const double x = lattice_.node(i, j0).x - middle.x;
            across[i - i0] = x * x;
        }
        for (std::uint32_t j = j0; j <= j1; ++j) {
            const double y = lattice_.node(i0, j).y - middle.y;
            Sum* const row = &sums_[static_cast<std::size_t>(j) * lattice_.nx + i0];
            for (std::uint32_t i = 0; i <= i1 - i0; ++i) {
                const double share = std::max(0.0, 1 - (across[i] + y * y) * inverse);
                const double part = weight * share * share;
                row[i].move = row[i].move + part * move;
                row[i].weight += part;
            }
        }
    }

    // Adds a motion from `start` at the middle of its way; a long one all along its way, so that it is found
    // there.
    void add_along(Vec2 start, Vec2 move, double sign, double weight) {
        const auto halves = static_cast<int>(std::floor(length(move) / radius_));
        for (int k = -halves; k <= halves; ++k) {
            const double share = halves == 0 ? 0.5 : 0.5 + 0.5 * k / halves;
            add(start + share * move, sign * move, weight / (2 * halves + 1));
        }
    }

    Vec2 mean(std::uint32_t i, std::uint32_t j) const {
        const Sum& sum = sums_[static_cast<std::size_t>(j) * lattice_.nx + i];
        return (1 / (sum.weight + at_rest_)) * sum.move;
    }

    // How much of a mean comes from boundaries: 0 away from them.
    double moved_share(std::uint32_t i, std::uint32_t j) const {
        const double weight = sums_[static_cast<std::size_t>(j) * lattice_.nx + i].weight;
        return weight / (weight + at_rest_);
    }

    Vec2 at(Vec2 q) const {
        const double x = (q.x - lattice_.low.x) / lattice_.step, y = (q.y - lattice_.low.y) / lattice_.step;
        if (!(x >= 0 && y >= 0 && x < lattice_.nx - 1.0 && y < lattice_.ny - 1.0)) return {};
        const auto i = static_cast<std::uint32_t>(x), j = static_cast<std::uint32_t>(y);
        const double u = x - i, v = y - j;
        return (1 - v) * ((1 - u) * mean(i, j) + u * mean(i + 1, j)) +
               v * ((1 - u) * mean(i, j + 1) + u * mean(i + 1, j + 1));
    }

    const Lattice& lattice() const { return lattice_; }

  private:
    struct Sum {
        Vec2 move;
        double weight = 0;
    };
    Lattice lattice_;
    double radius_, at_rest_;
    std::vector<Sum> sums_;
};

// A boundary ready to be matched with.
struct Side {
    Boundary boundary;
    PieceIndex index;
    Side(const DistanceMap& map, double gap) : boundary(boundary_of(map, gap)), index(boundary, gap) {}
};

// Adds the matches of the pieces of `from` in `to`. `sign`: 1 if `to` is the slice above, -1 if it is the one
// below. `before`: the motion of the round before.
void add_matches(const Side& from, const Side& to, double sign, double gap, const Average* before,
                 Average& average) {
    for (const Piece& piece : from.boundary.pieces) {
        if (piece.facing == Vec2{}) continue;
        const Vec2 start = piece.middle();
        Vec2 expected;
        if (before != nullptr) {
            const Vec2 middle = start + (0.5 * sign) * before->at(start);
            expected = sign * before->at(middle);
        }
        const PieceIndex::Match there = to.index.nearest(start, piece.facing, start + expected);
        if (there.piece == none) continue;
        const PieceIndex::Match back = from.index.nearest(there.point, piece.facing, there.point - expected);
        if (back.piece == none) continue;
        const double off = length(back.point - start) / (return_tolerance * gap);
        const Vec2 move = there.point - start;
        average.add_along(start, move, sign, piece.length / (1 + off * off));
    }
}

// Whether the regions have a common point: then one of them contains a boundary point of the other.
bool regions_overlap(const Side& below, const DistanceMap& below_map, const Side& above,
                     const DistanceMap& above_map) {
    const auto meets = [](const Side& side, const DistanceMap& map) {
        return std::any_of(side.boundary.pieces.begin(), side.boundary.pieces.end(),
                           [&](const Piece& piece) { return map.value(piece.a) <= 0; });
    };
    return meets(below, above_map) || meets(above, below_map);
}

}  // namespace

SliceMotion::SliceMotion(const DistanceMap& below, const DistanceMap& above, double gap, Beyond further_below,
                         Beyond further_above) {
    assert(gap > 0);
    const Side below_side(below, gap), above_side(above, gap);
    Box2 box;
    for (const DistanceMap* map : {&below, &above}) {
        box.extend(map->region_box().low);
        box.extend(map->region_box().high);
    }
    const double most =
        16.0 * static_cast<double>(below_side.boundary.pieces.size() + above_side.boundary.pieces.size()) +
        4096;
    std::unique_ptr<Average> average;
    for (std::size_t round = 0; round < averaging.size(); ++round) {
        const double radius = averaging[round] * gap;
        const bool is_last = round + 1 == averaging.size();
        const Lattice lattice(box.grown(averaging.back() * gap),
                              (is_last ? lattice_step : averaging[round] / 4) * gap, most);
        auto next = std::make_unique<Average>(lattice, std::max(radius, 2 * lattice.step), rest * gap);
        add_matches(below_side, above_side, 1, gap, average.get(), *next);
        add_matches(above_side, below_side, -1, gap, average.get(), *next);
        average = std::move(next);
    }
    const Lattice& lattice = average->lattice();
    low_ = lattice.low;
    step_ = lattice.step;
    inverse_step_ = 1 / step_;
    cells_x_ = lattice.nx - 1;
    cells_y_ = lattice.ny - 1;
    nodes_.resize(lattice.count());

    // The change of slope at a slice, by the three slices round it at their distances; in units of this gap.
    const auto bend = [&](double here, double slope, Beyond beyond, Vec2 q, double limit) {
        if (beyond.map == nullptr) return 0.0;
        const double there = std::clamp(beyond.map->value(q), -limit, limit);
        return gap / (gap + beyond.gap) * ((there - here) * (gap / beyond.gap) + slope);
    };
    for (std::uint32_t j = 0; j < lattice.ny; ++j) {
        for (std::uint32_t i = 0; i < lattice.nx; ++i) {
            const Vec2 q = lattice.node(i, j), move = average->mean(i, j);
            const double fade = average->moved_share(i, j);
            const Vec2 from = q - 0.5 * move, to = q + 0.5 * move;
            const double limit = std::min({gap, below.limit(), above.limit()});
            const double a = std::clamp(below.value(from), -limit, limit),
                         b = std::clamp(above.value(to), -limit, limit);
            const double bend_below =
                -fade * bend(a, b - a, further_below, from - (further_below.gap / gap) * move, limit);
            const double bend_above =
                fade * bend(b, a - b, further_above, to + (further_above.gap / gap) * move, limit);
            nodes_[static_cast<std::size_t>(j) * lattice.nx + i] = {
                static_cast<float>(move.x), static_cast<float>(move.y), static_cast<float>(bend_below),
                static_cast<float>(bend_above)};
            max_move_ = std::max(max_move_, length(move));
            max_bow_ = std::max(max_bow_, largest_bow({move, bend_below, bend_above}));
        }
    }
    overlaps_ = regions_overlap(below_side, below, above_side, above);
}

}  // namespace anatomesh
