#include "anatomesh/field/motion/slice_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>

#include "anatomesh/field/motion/aligned_outlines.h"
#include "anatomesh/field/motion/boundary_pieces.h"
#include "anatomesh/field/motion/motion_average.h"
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
// A piece of an aligned outline moves by no more than this beyond what its map says.
// [gaps; > 0; M 2026-11 oblique tubes]
constexpr double aligned_reach = 2;

// A slice whose pieces are matched: with what is known of its outlines beforehand.
struct MatchedSlice {
    const BoundarySide& side;
    const std::vector<NestedOutline>& nested;
    const std::vector<OutlineMap>& aligned;  // empty: none is
};

// Adds the matches of the pieces of `slice` in `to`. `sign`: 1 if `to` is the slice above, -1 if it is the one
// below. `before`: the motion of the round before.
void add_matches(const MatchedSlice& slice, const BoundarySide& to, double sign, double gap,
                 const MotionAverage* before, MotionAverage& average) {
    const BoundarySide& from = slice.side;
    for (std::uint32_t p = 0; p < from.boundary.pieces.size(); ++p) {
        const BoundaryPiece& piece = from.boundary.pieces[p];
        if (piece.facing == Vec2{}) continue;
        const Vec2 start = piece.middle();
        const std::uint32_t own = from.boundary.outline[p];
        std::uint32_t other = slice.nested[own].other;
        double reach = slice.nested[own].reach;
        const bool is_aligned = !slice.aligned.empty() && slice.aligned[own].other != no_piece;
        Vec2 expected;
        if (is_aligned) {
            expected = slice.aligned[own](start) - start;
            other = slice.aligned[own].other;
            reach = length(expected) + aligned_reach * gap;
        }
        if (before != nullptr) {
            const Vec2 middle = start + (0.5 * sign) * before->at(start);
            expected = sign * before->at(middle);
        }
        // An aligned outline corresponds to one alone, however near others are.
        const auto nearest = [&](const PieceIndex& index, Vec2 at, Vec2 target, std::uint32_t outline) {
            PieceIndex::Match match;
            if (!is_aligned) match = index.nearest(at, piece.facing, target);
            if (match.piece == no_piece && outline != no_piece)
                match = index.nearest(at, piece.facing, target, reach, outline);
            return match;
        };
        const PieceIndex::Match there = nearest(to.index, start, start + expected, other);
        if (there.piece == no_piece) continue;
        const bool is_other = other == to.boundary.outline[there.piece];
        const PieceIndex::Match back =
            nearest(from.index, there.point, there.point - expected, is_other ? own : no_piece);
        if (back.piece == no_piece) continue;
        const double off = length(back.point - start) / (return_tolerance * gap);
        const Vec2 move = there.point - start;
        average.add_along(start, move, sign, piece.length / (1 + off * off));
    }
}

// The motion after all rounds. `box`: that of both regions.
std::unique_ptr<MotionAverage> averaged_matches(const MatchedSlice& below, const MatchedSlice& above,
                                                const Box2& box, double gap) {
    const double most =
        16.0 * static_cast<double>(below.side.boundary.pieces.size() + above.side.boundary.pieces.size()) +
        4096;
    std::unique_ptr<MotionAverage> average;
    for (std::size_t round = 0; round < averaging.size(); ++round) {
        const double radius = averaging[round] * gap;
        const bool is_last = round + 1 == averaging.size();
        const MotionLattice lattice(box.grown(averaging.back() * gap),
                                    (is_last ? lattice_step : averaging[round] / 4) * gap, most);
        auto next = std::make_unique<MotionAverage>(lattice, std::max(radius, 2 * lattice.step), rest * gap);
        add_matches(below, above.side, 1, gap, average.get(), *next);
        add_matches(above, below.side, -1, gap, average.get(), *next);
        average = std::move(next);
    }
    return average;
}

// Whether the regions have a common point: then one of them contains a boundary point of the other. Of two
// circles of many points, turned against each other, no vertex lies in the other, but middles of edges do.
bool regions_overlap(const BoundarySide& below, const DistanceMap& below_map, const BoundarySide& above,
                     const DistanceMap& above_map) {
    const auto meets = [](const BoundarySide& side, const DistanceMap& map) {
        return std::any_of(side.boundary.pieces.begin(), side.boundary.pieces.end(),
                           [&](const BoundaryPiece& piece) {
                               return map.value(piece.a) <= 0 || map.value(piece.middle()) <= 0;
                           });
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
    const auto [below_nested, above_nested] = nested_outlines(below_side.boundary, above_side.boundary, gap);
    const Neighbour lower{below, further_below}, upper{above, further_above};
    const auto find_paths = [&, &in_below = below_nested,
                             &in_above = above_nested](const AlignedOutlines& aligned) {
        set_paths(*averaged_matches({below_side, in_below, aligned.below},
                                    {above_side, in_above, aligned.above}, box, gap),
                  lower, upper, gap);
    };
    find_paths({});
    const CarriedSlice carried_up{below_side.boundary, below, amiss(below_side.boundary, above, true)},
        carried_down{above_side.boundary, above, amiss(above_side.boundary, below, false)};
    if (const AlignedOutlines aligned = aligned_outlines(carried_up, carried_down, gap); !aligned.empty()) {
        find_paths(aligned);
        is_aligned_ = true;
    }
    overlaps_ = regions_overlap(below_side, below, above_side, above);
    ambiguities_ = anatomesh::ambiguities(below_side, below, above_side, above);
}

std::vector<double> SliceMotion::amiss(const Boundary& boundary, const DistanceMap& other,
                                       bool upwards) const {
    std::vector<Vec2> carried;
    carried.reserve(boundary.pieces.size());
    for (const BoundaryPiece& piece : boundary.pieces) {
        const Vec2 move = at(piece.middle(), upwards ? 0 : 1).move;
        carried.push_back(upwards ? piece.middle() + move : piece.middle() - move);
    }
    return amiss_shares(boundary, other, carried);
}

void SliceMotion::set_paths(const MotionAverage& average, const Neighbour& lower, const Neighbour& upper,
                            double gap) {
    const MotionLattice& lattice = average.lattice();
    low_ = lattice.low;
    step_ = lattice.step;
    inverse_step_ = 1 / step_;
    cells_x_ = lattice.nx - 1;
    cells_y_ = lattice.ny - 1;
    nodes_.resize(lattice.count());
    max_move_ = max_correction_ = 0;
    const DistanceMap &below = lower.map, &above = upper.map;
    const Beyond &further_below = lower.further, &further_above = upper.further;

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
            const Vec2 q = lattice.node(i, j), move = average.mean(i, j);
            const double fade = average.moved_share(i, j);
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
}

}  // namespace anatomesh
