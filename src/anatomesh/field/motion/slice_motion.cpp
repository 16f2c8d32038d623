#include "anatomesh/field/motion/slice_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>

#include "anatomesh/base/instruction_sets.h"
#include "anatomesh/field/motion/boundary_pieces.h"
#include "anatomesh/field/motion/nested_outlines.h"

namespace anatomesh {

namespace {

// A match that leads back this far from its start counts half: it is not sure.
// [gaps; > 0; M 2026-11 skull, slices left out]
constexpr double return_tolerance = 0.5;
// Every average contains so much boundary that does not move, so that the motion fades where nothing is
// matched. [gaps, of length; > 0; M 2026-11 skull, slices left out]
constexpr double rest = 0.1;
// The motion is kept on a lattice of this step: it is an average over several steps and changes little within
// one. [gaps; > 0; B]
constexpr double lattice_step = 0.5;
// A part this much further away than the nearest boundary counts as it: the two are one within the lattice.
// [1; >= 1; D]
constexpr double nearest_share = 1.1;
// Matches are averaged within these radii, round by round: from coarse to fine, so that a few wrong ones give
// way to their neighbourhood. [gaps; > 0, falling; M 2026-11 skull, slices left out]
constexpr std::array<double, 3> averaging{4.4, 2.8, 1.8};
// A radius of averaging is four steps of a lattice at most, so it covers no more columns. [columns; 12; D]
constexpr std::uint32_t most_columns = 12;

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
        : lattice_(lattice),
          radius_(radius),
          at_rest_(at_rest),
          moves_x_(lattice.count()),
          moves_y_(lattice.count()),
          weights_(lattice.count()) {}

    ANATOMESH_CLONES void add(Vec2 middle, Vec2 move, double weight) {
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
            const std::size_t row = static_cast<std::size_t>(j) * lattice_.nx + i0;
            std::array<double, most_columns> parts;
            for (std::uint32_t i = 0; i <= i1 - i0; ++i) {
                const double share = std::max(0.0, 1 - (across[i] + y * y) * inverse);
                parts[i] = weight * share * share;
            }
            add_row(&moves_x_[row], parts, i1 - i0 + 1, move.x);
            add_row(&moves_y_[row], parts, i1 - i0 + 1, move.y);
            add_row(&weights_[row], parts, i1 - i0 + 1, 1);
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
        const std::size_t n = static_cast<std::size_t>(j) * lattice_.nx + i;
        return (1 / (weights_[n] + at_rest_)) * Vec2{moves_x_[n], moves_y_[n]};
    }

    // How much of a mean comes from boundaries: 0 away from them.
    double moved_share(std::uint32_t i, std::uint32_t j) const {
        const double weight = weights_[static_cast<std::size_t>(j) * lattice_.nx + i];
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
    static void add_row(double* sums, const std::array<double, most_columns>& parts, std::uint32_t count,
                        double factor) {
        for (std::uint32_t i = 0; i < count; ++i) sums[i] += parts[i] * factor;
    }
    Lattice lattice_;
    double radius_, at_rest_;
    std::vector<double> moves_x_, moves_y_, weights_;  // sums of weighted moves, and of the weights; by node
};

// Adds the matches of the pieces of `from` in `to`. `sign`: 1 if `to` is the slice above, -1 if it is the one
// below. `before`: the motion of the round before.
void add_matches(const BoundarySide& from, const BoundarySide& to, const std::vector<NestedOutline>& nested,
                 double sign, double gap, const Average* before, Average& average) {
    for (std::uint32_t p = 0; p < from.boundary.pieces.size(); ++p) {
        const BoundaryPiece& piece = from.boundary.pieces[p];
        if (piece.facing == Vec2{}) continue;
        const Vec2 start = piece.middle();
        Vec2 expected;
        if (before != nullptr) {
            const Vec2 middle = start + (0.5 * sign) * before->at(start);
            expected = sign * before->at(middle);
        }
        const NestedOutline& nest = nested[from.boundary.outline[p]];
        PieceIndex::Match there = to.index.nearest(start, piece.facing, start + expected);
        if (there.piece == no_piece && nest.other != no_piece)
            there = to.index.nearest(start, piece.facing, start + expected, nest.reach, nest.other);
        if (there.piece == no_piece) continue;
        const Vec2 expected_back = there.point - expected;
        PieceIndex::Match back = from.index.nearest(there.point, piece.facing, expected_back);
        if (back.piece == no_piece && nest.other == to.boundary.outline[there.piece])
            back = from.index.nearest(there.point, piece.facing, expected_back, nest.reach,
                                      from.boundary.outline[p]);
        if (back.piece == no_piece) continue;
        const double off = length(back.point - start) / (return_tolerance * gap);
        const Vec2 move = there.point - start;
        average.add_along(start, move, sign, piece.length / (1 + off * off));
    }
}

// Whether the regions have a common point: then one of them contains a boundary point of the other.
bool regions_overlap(const BoundarySide& below, const DistanceMap& below_map, const BoundarySide& above,
                     const DistanceMap& above_map) {
    const auto meets = [](const BoundarySide& side, const DistanceMap& map) {
        return std::any_of(side.boundary.pieces.begin(), side.boundary.pieces.end(),
                           [&](const BoundaryPiece& piece) { return map.value(piece.a) <= 0; });
    };
    return meets(below, above_map) || meets(above, below_map);
}

}  // namespace

SliceMotion::SliceMotion(const DistanceMap& below, const DistanceMap& above, double gap, Beyond further_below,
                         Beyond further_above) {
    assert(gap > 0);
    const BoundarySide below_side(below, gap), above_side(above, gap);
    Box2 box;
    for (const DistanceMap* map : {&below, &above}) {
        box.extend(map->region_box().low);
        box.extend(map->region_box().high);
    }
    const double most =
        16.0 * static_cast<double>(below_side.boundary.pieces.size() + above_side.boundary.pieces.size()) +
        4096;
    const auto [below_nested, above_nested] = nested_outlines(below_side.boundary, above_side.boundary, gap);
    std::unique_ptr<Average> average;
    for (std::size_t round = 0; round < averaging.size(); ++round) {
        const double radius = averaging[round] * gap;
        const bool is_last = round + 1 == averaging.size();
        const Lattice lattice(box.grown(averaging.back() * gap),
                              (is_last ? lattice_step : averaging[round] / 4) * gap, most);
        auto next = std::make_unique<Average>(lattice, std::max(radius, 2 * lattice.step), rest * gap);
        add_matches(below_side, above_side, below_nested, 1, gap, average.get(), *next);
        add_matches(above_side, below_side, above_nested, -1, gap, average.get(), *next);
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
    const auto ends = [](const Beyond& beyond, Vec2 q, double here) {
        return std::any_of(beyond.ending.begin(), beyond.ending.end(), [&](const DistanceMap* part) {
            return std::abs(part->value(q)) <= nearest_share * std::abs(here);
        });
    };
    const auto curvature = [&](double here, double slope, const Beyond& beyond, Vec2 q, double limit) {
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
            const double in_below = below.value(from), in_above = above.value(to);
            const double a = std::clamp(in_below, -limit, limit), b = std::clamp(in_above, -limit, limit);
            const double curvature_below =
                ends(further_below, from, in_below)
                    ? 0
                    : -fade *
                          curvature(a, b - a, further_below, from - (further_below.gap / gap) * move, limit);
            const double curvature_above =
                ends(further_above, to, in_above)
                    ? 0
                    : fade * curvature(b, a - b, further_above, to + (further_above.gap / gap) * move, limit);
            nodes_[static_cast<std::size_t>(j) * lattice.nx + i] = {
                static_cast<float>(move.x), static_cast<float>(move.y), static_cast<float>(curvature_below),
                static_cast<float>(curvature_above)};
            max_move_ = std::max(max_move_, length(move));
            max_correction_ =
                std::max(max_correction_, largest_correction({move, curvature_below, curvature_above}));
        }
    }
    overlaps_ = regions_overlap(below_side, below, above_side, above);
    ambiguities_ = anatomesh::ambiguities(below_side, below, above_side, above);
}

}  // namespace anatomesh
