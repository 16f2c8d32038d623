#include "anatomesh/field/motion/boundary_pieces.h"

#include <tuple>
#include <utility>

namespace anatomesh {

namespace {

// Longer edges are matched in pieces of this length, as long as the steps of the lattice on which the motion
// is kept. [gaps; > 0; D]
constexpr double piece_length = 0.5;
// A piece faces across the chord that ends this far along the boundary on both sides, so that steps of pixels
// do not count. [gaps; > 0; M 2026-11 skull, slices left out]
constexpr double facing_reach = 0.5;
// No boundary moves further; a cap that ends may (nested_outlines.h).
// [gaps; > 0; M 2026-11 skull, slices left out]
constexpr double search_reach = 3.5;
// A match that turns by a right angle costs as much as one this far away.
// [gaps; > 0; M 2026-11 skull, slices left out]
constexpr double turn_cost = 0.5;
// Pieces that face further apart than 72 degrees, of which this is the cosine, are never matched: outer walls
// match outer walls. [1, cosine; 0 to 1; M 2026-11 skull, slices left out]
constexpr double least_cosine = 0.3;

// The point `reach` along the boundary from the middle of piece p, with `step` from piece to piece.
Vec2 along(const Boundary& boundary, std::uint32_t p, const std::vector<std::uint32_t>& step, bool forward,
           double reach) {
    const auto far_end = [&](const BoundaryPiece& piece) { return forward ? piece.b : piece.a; };
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
        if (at == no_piece || at == p) return from;
    }
}

}  // namespace

// The edge that starts where each edge ends; where several do, the first that is not taken yet.
std::vector<std::uint32_t> following_edges(std::span<const Edge2> edges) {
    const auto key = [](Vec2 p) { return std::pair(p.x, p.y); };
    std::vector<std::uint32_t> by_start(edges.size()), next(edges.size(), no_piece);
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

Boundary boundary_of(const DistanceMap& map, double gap) {
    Boundary boundary;
    const std::span<const Edge2> edges = map.edges();
    const std::vector<std::uint32_t> next_edge = following_edges(edges);
    std::vector<std::uint32_t>& first = boundary.first;
    first.assign(edges.size() + 1, 0);
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
    boundary.next.assign(boundary.pieces.size(), no_piece);
    boundary.previous.assign(boundary.pieces.size(), no_piece);
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        for (std::uint32_t p = first[e]; p < first[e + 1]; ++p) {
            boundary.next[p] = p + 1 < first[e + 1]       ? p + 1
                               : next_edge[e] == no_piece ? no_piece
                                                          : first[next_edge[e]];
            if (boundary.next[p] != no_piece) boundary.previous[boundary.next[p]] = p;
        }
    }
    for (std::uint32_t p = 0; p < boundary.pieces.size(); ++p) {
        const double reach = std::min(facing_reach * gap, 0.125 * perimeter);
        const Vec2 chord = along(boundary, p, boundary.next, true, reach) -
                           along(boundary, p, boundary.previous, false, reach);
        const double size = length(chord);
        if (size > 0.1 * reach) boundary.pieces[p].facing = (1 / size) * Vec2{chord.y, -chord.x};
    }
    boundary.outline.assign(boundary.pieces.size(), no_piece);
    for (std::uint32_t p = 0; p < boundary.pieces.size(); ++p) {
        if (boundary.outline[p] != no_piece) continue;
        for (std::uint32_t at = p; at != no_piece && boundary.outline[at] == no_piece; at = boundary.next[at])
            boundary.outline[at] = boundary.outlines;
        ++boundary.outlines;
    }
    return boundary;
}

PieceIndex::PieceIndex(const Boundary& boundary, double gap) : gap_(gap) {
    const std::vector<BoundaryPiece>& pieces = boundary.pieces;
    for (const BoundaryPiece& piece : pieces) box_.extend(piece.middle());
    // Never many more bins than pieces, however large the region.
    const Vec2 size = box_.high - box_.low;
    const double most = 4.0 * static_cast<double>(pieces.size()) + 64;
    bin_ = std::max({0.5 * gap, std::sqrt(size.x * size.y / most), std::max(size.x, size.y) / most});
    nx_ = static_cast<std::int64_t>(size.x / bin_) + 1;
    ny_ = static_cast<std::int64_t>(size.y / bin_) + 1;
    begin_.assign(static_cast<std::size_t>(nx_ * ny_) + 1, 0);
    for (const BoundaryPiece& piece : pieces) ++begin_[bin_of(piece.middle()) + 1];
    for (std::size_t b = 1; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    listed_.resize(pieces.size());
    for (std::uint32_t p = 0; p < pieces.size(); ++p) {
        const BoundaryPiece& piece = pieces[p];
        const Vec2 edge = piece.b - piece.a;
        listed_[next[bin_of(piece.middle())]++] = {
            piece.a, edge, piece.facing, 1 / squared_length(edge), p, boundary.outline[p]};
    }
}

std::size_t PieceIndex::bin_of(Vec2 q) const {
    const std::int64_t i = std::clamp<std::int64_t>(column(q.x, box_.low.x), 0, nx_ - 1);
    const std::int64_t j = std::clamp<std::int64_t>(column(q.y, box_.low.y), 0, ny_ - 1);
    return static_cast<std::size_t>(j * nx_ + i);
}

// The pieces in the bins from `first` to `last` of row j, which lie together.
template <class Body>
void PieceIndex::each_in_row(std::int64_t j, std::int64_t first, std::int64_t last, const Body& body) const {
    if (j < 0 || j >= ny_ || first >= nx_ || last < 0) return;
    const auto row = static_cast<std::size_t>(j * nx_);
    const std::uint32_t end = begin_[row + static_cast<std::size_t>(std::min(last, nx_ - 1)) + 1];
    for (std::uint32_t l = begin_[row + static_cast<std::size_t>(std::max<std::int64_t>(first, 0))]; l < end;
         ++l) {
        body(listed_[l]);
    }
}

PieceIndex::Match PieceIndex::nearest(Vec2 from, Vec2 facing, Vec2 target) const {
    return search(from, facing, target, search_reach * gap_, [](const Listed&) { return true; });
}

PieceIndex::Match PieceIndex::nearest(Vec2 from, Vec2 facing, Vec2 target, double reach,
                                      std::uint32_t outline) const {
    return search(from, facing, target, reach, [&](const Listed& piece) { return piece.outline == outline; });
}

template <class Accepts>
PieceIndex::Match PieceIndex::search(Vec2 from, Vec2 facing, Vec2 target, double most,
                                     const Accepts& accepts) const {
    Match best;
    const double turn = 2 * turn_cost * turn_cost * gap_ * gap_;
    double best_cost = most * most;
    const auto compare = [&](const Listed& piece) {
        const double cosine = dot(piece.facing, facing);
        if (cosine < least_cosine || !accepts(piece)) return;
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

}  // namespace anatomesh
