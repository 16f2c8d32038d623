#include "anatomesh/sample/conform_pieces.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/sample/piece_apexes.h"

namespace anatomesh {

namespace {

constexpr int most_rounds = 24;
constexpr double near_share = 0.5;    // of the shortest length
constexpr double in_ball = 1 - 1e-9;  // a vertex on its sphere is not in it
constexpr double cell_share = 1.5;    // of the mean length of the pieces: a cell of the grid
constexpr std::size_t grain = 512;    // pieces at a time
constexpr std::uint32_t no_vertex = 0xFFFFFFFFu;

using VertexPair = std::array<std::uint32_t, 2>;
using Owner = std::array<std::uint32_t, 2>;  // a point, and a structure with a contour through it

class Conformer {
  public:
    Conformer(std::vector<Vec3>& points, const std::vector<SegmentPiece>& pieces, SegmentGuard& guard,
              const ConformOptions& options)
        : points_(points),
          guard_(guard),
          shortest_(options.shortest_mm),
          growth_(options.growth),
          graded_room_(growth_ > 0 ? options.shortest_graded_mm / (2 * growth_) : 0),
          shortest_graded_(options.shortest_mm),
          ungraded_before_(options.shortest_mm),
          threads_(options.threads),
          slices_(options.slices),
          acute_(acute_vertices(points, pieces)),
          apexes_(slices_.empty() ? PieceApexes(points, pieces, acute_) : PieceApexes()),
          cell_size_(cell_share * mean_length(points, pieces)),
          grid_(cell_size_, points.size()),
          fresh_(cell_size_, 0) {
        for (const Vec3& p : points) grid_.add(p);
        if (slices_.empty()) return;
        for (const SegmentPiece& piece : pieces) {
            owners_.push_back({piece.a, piece.structure});
            owners_.push_back({piece.b, piece.structure});
        }
        std::sort(owners_.begin(), owners_.end());
    }

    // From now on pieces are graded down to this length.
    void grade_to(double shortest) {
        ungraded_before_ = shortest_graded_;
        shortest_graded_ = shortest;
    }

    // Says whether any was split.
    bool split_round(std::vector<SegmentPiece>& pieces) {
        const std::vector<Want> wants = find_wants(pieces);
        const std::size_t first_new = points_.size();
        fresh_ = PointGrid(cell_size_, 0);
        std::vector<SegmentPiece> next;
        // Pieces of several structures with one ball follow each other.
        for (std::size_t n = 0, last = 0; n < pieces.size(); n = last) {
            while (last < pieces.size() && pieces[last].ball == pieces[n].ball) ++last;
            const std::optional<Vec3> at = place_of_split(pieces[n], wants[n]);
            if (!at) {
                next.insert(next.end(), pieces.begin() + n, pieces.begin() + last);
                continue;
            }
            const auto v = static_cast<std::uint32_t>(points_.size());
            points_.push_back(*at);
            fresh_.add(*at);
            if (!slices_.empty()) {
                slices_.push_back(slices_[pieces[n].a]);
                for (std::size_t k = n; k < last; ++k) owners_.push_back({v, pieces[k].structure});
            }
            guard_.drop_ball(pieces[n].ball);
            const std::uint32_t low = guard_.add_segment(points_[pieces[n].a], *at);
            const std::uint32_t high = guard_.add_segment(*at, points_[pieces[n].b]);
            apexes_.pass_on(pieces[n], low, high);
            for (std::size_t k = n; k < last; ++k) next.push_back({pieces[k].a, v, pieces[k].structure, low});
            for (std::size_t k = n; k < last; ++k)
                next.push_back({v, pieces[k].b, pieces[k].structure, high});
        }
        for (std::size_t n = first_new; n < points_.size(); ++n) {
            grid_.add(points_[n]);
            guard_.add_point(points_[n]);
        }
        pieces = std::move(next);
        first_fresh_ = first_new;
        ungraded_before_ = shortest_graded_;
        return points_.size() > first_new;
    }

  private:
    // Why a piece should be split.
    struct Want {
        bool encroached = false, ungraded = false;
        std::uint32_t beside = no_vertex;  // where nothing else is possible, opposite to this one
        bool any() const { return encroached || ungraded; }
    };

    bool is_taken(Vec3 p, double room) const {
        return grid_.any_within(p, room) || fresh_.any_within(p, room);
    }
    // But for points on the shell of p about the apex.
    bool is_taken(Vec3 p, double room, Vec3 apex) const {
        return SegmentGuard::any_within(grid_, p, room, apex) ||
               SegmentGuard::any_within(fresh_, p, room, apex);
    }

    // If nothing is too near there. Where planes cross on shells, on which all that meet at an apex may be
    // split side by side: were every other one split, those between would have vertices in their balls for
    // good.
    std::optional<Vec3> place_of_split(const SegmentPiece& piece, const Want& want) const {
        if (want.any()) {
            const double room = near_share * shortest_;
            if (const std::optional<std::uint32_t> apex = apexes_.of(piece)) {
                const Vec3 at = shell_point(points_, piece, points_[*apex]);
                if (!is_taken(at, room, points_[*apex])) return at;
                return std::nullopt;
            }
            const Vec3 at = split_point(points_, piece, acute_);
            if (want.encroached && !is_taken(at, room)) return at;
            if (want.ungraded && !is_taken(at, graded_room_) && !is_in_corner(at, piece)) return at;
        }
        if (want.beside == no_vertex) return std::nullopt;
        const Vec3 beside = points_[want.beside];
        const std::optional<Vec3> foot = foot_on(points_, piece, beside);
        if (!foot || is_taken(*foot, foot_room * length(beside - *foot))) return std::nullopt;
        return foot;
    }

    // Of the first piece of each ball.
    std::vector<Want> find_wants(const std::vector<SegmentPiece>& pieces) {
        if (growth_ > 0) find_neighbors(pieces);
        std::vector<Want> wants(pieces.size());
        parallel_for(pieces.size(), grain, threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                if (n > 0 && pieces[n - 1].ball == pieces[n].ball) continue;
                std::size_t last = n + 1;
                while (last < pieces.size() && pieces[last].ball == pieces[n].ball) ++last;
                if (may_have_changed(pieces[n])) {
                    const std::span<const SegmentPiece> all = std::span(pieces).subspan(n, last - n);
                    wants[n] = {is_encroached(all), is_ungraded(pieces[n]), vertex_beside(all)};
                }
            }
        });
        return wants;
    }

    // Since the last round: a piece that was to stay, or could not be split, is looked at again when a point
    // came near it, or shorter ones may be graded. (What is in its way stays.)
    bool may_have_changed(const SegmentPiece& piece) const {
        if (piece.a >= first_fresh_ || piece.b >= first_fresh_) return true;
        const Vec3 a = points_[piece.a], way = points_[piece.b] - a;
        const double span = length(way);
        if (span < 2 * ungraded_before_ && span >= 2 * shortest_graded_) return true;
        return fresh_.any_within(a + 0.5 * way, growth_ > 0 ? span * (0.5 + 1 / growth_) : 0.5 * span);
    }

    static double mean_length(const std::vector<Vec3>& points, const std::vector<SegmentPiece>& pieces) {
        double total = 0;
        for (const SegmentPiece& piece : pieces) total += length(points[piece.b] - points[piece.a]);
        return total / static_cast<double>(pieces.size());
    }

    // Pieces of one ball. Of what is nearer than points may lie only what shells can keep apart.
    bool is_encroached(std::span<const SegmentPiece> all) const {
        const SegmentPiece& piece = all[0];
        const Vec3 a = points_[piece.a], way = points_[piece.b] - a;
        const double span = length(way);
        if (span < 2 * shortest_) return false;
        const std::optional<std::uint32_t> apex = apexes_.of(piece);
        bool found = false;
        grid_.for_each_within(a + 0.5 * way, 0.5 * in_ball * span, [&](std::uint32_t v, double) {
            if (found || v == piece.a || v == piece.b || !counts(v, all)) return;
            const double distance = length(cross(way, points_[v] - a)) / span;
            found = distance > near_share * shortest_ ||
                    (apex && distance > SegmentGuard::least_angle * length(points_[v] - points_[*apex]));
        });
        return found;
    }

    void find_neighbors(const std::vector<SegmentPiece>& pieces) {
        neighbors_.clear();
        for (const SegmentPiece& piece : pieces) {
            neighbors_.push_back({piece.a, piece.b});
            neighbors_.push_back({piece.b, piece.a});
        }
        std::sort(neighbors_.begin(), neighbors_.end());
    }

    // Whether another vertex of the slice is nearer to the piece than its length allows. At a small angle
    // the next vertices on both sides are as near as they may be.
    bool is_ungraded(const SegmentPiece& piece) const {
        if (!(growth_ > 0)) return false;
        const Vec3 a = points_[piece.a], way = points_[piece.b] - a;
        const double span = length(way), reach = span / growth_;
        if (span < 2 * shortest_graded_) return false;
        bool found = false;
        grid_.for_each_within(a + 0.5 * way, 0.5 * span + reach, [&](std::uint32_t v, double) {
            if (found || v == piece.a || v == piece.b || slices_[v] != slices_[piece.a]) return;
            const double share = std::clamp(dot(points_[v] - a, way) / (span * span), 0.0, 1.0);
            if (squared_length(points_[v] - (a + share * way)) >= reach * reach) return;
            found = !is_next(v, piece);
        });
        return found;
    }

    // Whether a piece that meets this one at a small angle is nearer to a point on it than graded points may
    // lie to each other: that one could not follow, and would have the point in its ball.
    bool is_in_corner(Vec3 at, const SegmentPiece& piece) const {
        const auto next_is_near = [&](std::uint32_t end) {
            auto n = std::lower_bound(neighbors_.begin(), neighbors_.end(), VertexPair{end, 0});
            for (; n != neighbors_.end() && (*n)[0] == end; ++n) {
                const std::uint32_t v = (*n)[1];
                if (v == piece.a || v == piece.b || !is_next(v, piece)) continue;
                const Vec3 way = points_[v] - points_[end], to = at - points_[end];
                if (dot(to, way) < squared_length(way) && length(cross(way, to)) < graded_room_ * length(way))
                    return true;
            }
            return false;
        };
        return next_is_near(piece.a) || next_is_near(piece.b);
    }

    // Whether a piece to v meets this one at a small angle.
    bool is_next(std::uint32_t v, const SegmentPiece& piece) const {
        const auto at = [&](std::uint32_t end, std::uint32_t other) {
            return std::binary_search(neighbors_.begin(), neighbors_.end(), VertexPair{end, v}) &&
                   dot(points_[v] - points_[end], points_[other] - points_[end]) > 0;
        };
        return at(piece.a, piece.b) || at(piece.b, piece.a);
    }

    // A vertex in the ball of these pieces that grading does not heed: the next at a small angle, or one too
    // near. Of several the one nearest to the middle.
    std::uint32_t vertex_beside(std::span<const SegmentPiece> all) const {
        const Vec3 a = points_[all[0].a], way = points_[all[0].b] - a;
        const double span = length(way);
        std::uint32_t found = no_vertex;
        if (!(growth_ > 0) || span < 2 * shortest_graded_) return found;
        double nearest = HUGE_VAL;
        grid_.for_each_within(a + 0.5 * way, 0.5 * in_ball * span, [&](std::uint32_t v, double squared) {
            if (v == all[0].a || v == all[0].b || !counts(v, all)) return;
            if (length(cross(way, points_[v] - a)) >= graded_room_ * span && !is_next(v, all[0])) return;
            if (squared > nearest || (squared == nearest && v > found)) return;
            nearest = squared;
            found = v;
        });
        return found;
    }

    bool counts(std::uint32_t v, std::span<const SegmentPiece> all) const {
        if (slices_.empty()) return true;
        if (slices_[v] != slices_[all[0].a]) return false;
        return std::none_of(all.begin(), all.end(), [&](const SegmentPiece& piece) {
            return std::binary_search(owners_.begin(), owners_.end(), Owner{v, piece.structure});
        });
    }

    std::vector<Vec3>& points_;
    SegmentGuard& guard_;
    const double shortest_, growth_, graded_room_;
    double shortest_graded_;       // so far
    double ungraded_before_;       // what it was in the last round
    std::size_t first_fresh_ = 0;  // the first point of the last round
    const int threads_;
    std::vector<std::uint32_t> slices_;  // by point, or empty
    std::vector<Owner> owners_;          // sorted; with slices
    std::vector<VertexPair> neighbors_;  // sorted: ends of pieces, both ways; with growth_
    const std::vector<std::uint32_t> acute_;
    PieceApexes apexes_;  // of none within slices
    const double cell_size_;
    PointGrid grid_, fresh_;  // of all points, and of those of the last round
};

}  // namespace

std::size_t conform_pieces(std::vector<Vec3>& points, std::vector<SegmentPiece>& pieces, SegmentGuard& guard,
                           const ConformOptions& options) {
    assert(options.shortest_mm > 0);
    if (pieces.empty()) return 0;
    const std::size_t before = points.size();
    Conformer conformer(points, pieces, guard, options);
    const auto split_all = [&] {
        for (int round = 0; round < most_rounds && conformer.split_round(pieces); ++round) {
        }
    };
    split_all();
    if (!(options.growth > 0)) return points.size() - before;
    // Step by step: outlines that run beside each other all the way must not ask for many times the points.
    for (double shortest = options.shortest_mm;
         shortest > options.shortest_graded_mm &&
         static_cast<double>(points.size()) <= (1 + options.most_added) * static_cast<double>(before);) {
        shortest = std::max(0.5 * shortest, options.shortest_graded_mm);
        conformer.grade_to(shortest);
        split_all();
    }
    return points.size() - before;
}

}  // namespace anatomesh
