#include "anatomesh/sample/conform_pieces.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <span>

#include "anatomesh/geom/point_grid.h"

namespace anatomesh {

namespace {

constexpr int most_rounds = 24;
constexpr double near_share = 0.5;    // of the shortest length
constexpr double in_ball = 1 - 1e-9;  // a vertex on its sphere is not in it
constexpr double cell_share = 0.5;    // of the mean length of the pieces: a cell of the grid

using Owner = std::array<std::uint32_t, 2>;  // a point, and a structure with a contour through it

class Conformer {
  public:
    Conformer(std::vector<Vec3>& points, const std::vector<SegmentPiece>& pieces, SegmentGuard& guard,
              const ConformOptions& options)
        : points_(points),
          guard_(guard),
          shortest_(options.shortest_mm),
          slices_(options.slices),
          acute_(acute_vertices(points, pieces)),
          grid_(cell_share * mean_length(points, pieces), points.size()) {
        for (const Vec3& p : points) grid_.add(p);
        if (slices_.empty()) return;
        for (const SegmentPiece& piece : pieces) {
            owners_.push_back({piece.a, piece.structure});
            owners_.push_back({piece.b, piece.structure});
        }
        std::sort(owners_.begin(), owners_.end());
    }

    // Says whether any was split.
    bool split_round(std::vector<SegmentPiece>& pieces) {
        const std::size_t first_new = points_.size();
        std::vector<SegmentPiece> next;
        // Pieces of several structures with one ball follow each other.
        for (std::size_t n = 0, last = 0; n < pieces.size(); n = last) {
            while (last < pieces.size() && pieces[last].ball == pieces[n].ball) ++last;
            const Vec3 at = split_point(points_, pieces[n], acute_);
            const std::span<const SegmentPiece> all(pieces.data() + n, last - n);
            if (!is_encroached(all) || is_taken(at, first_new)) {
                next.insert(next.end(), all.begin(), all.end());
                continue;
            }
            const auto v = static_cast<std::uint32_t>(points_.size());
            points_.push_back(at);
            if (!slices_.empty()) {
                slices_.push_back(slices_[pieces[n].a]);
                for (const SegmentPiece& piece : all) owners_.push_back({v, piece.structure});
            }
            guard_.drop_ball(pieces[n].ball);
            const std::uint32_t low = guard_.add_segment(points_[pieces[n].a], at);
            const std::uint32_t high = guard_.add_segment(at, points_[pieces[n].b]);
            for (std::size_t k = n; k < last; ++k) next.push_back({pieces[k].a, v, pieces[k].structure, low});
            for (std::size_t k = n; k < last; ++k)
                next.push_back({v, pieces[k].b, pieces[k].structure, high});
        }
        for (std::size_t n = first_new; n < points_.size(); ++n) {
            grid_.add(points_[n]);
            guard_.add_point(points_[n]);
        }
        pieces = std::move(next);
        return points_.size() > first_new;
    }

  private:
    static double mean_length(const std::vector<Vec3>& points, const std::vector<SegmentPiece>& pieces) {
        double total = 0;
        for (const SegmentPiece& piece : pieces) total += length(points[piece.b] - points[piece.a]);
        return total / static_cast<double>(pieces.size());
    }

    // Pieces of one ball.
    bool is_encroached(std::span<const SegmentPiece> all) const {
        const SegmentPiece& piece = all[0];
        const Vec3 a = points_[piece.a], way = points_[piece.b] - a;
        const double span = length(way);
        if (span < 2 * shortest_) return false;
        bool found = false;
        grid_.for_each_within(a + 0.5 * way, 0.5 * in_ball * span, [&](std::uint32_t v, double) {
            found = found || (v != piece.a && v != piece.b && counts(v, all) &&
                              length(cross(way, points_[v] - a)) > near_share * shortest_ * span);
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

    // By a point that was there, or one of this round.
    bool is_taken(Vec3 p, std::size_t first_new) const {
        const double room = near_share * shortest_;
        return grid_.any_within(p, room) ||
               std::any_of(points_.begin() + static_cast<std::ptrdiff_t>(first_new), points_.end(),
                           [&](Vec3 q) { return squared_length(q - p) < room * room; });
    }

    std::vector<Vec3>& points_;
    SegmentGuard& guard_;
    const double shortest_;
    std::vector<std::uint32_t> slices_;  // by point, or empty
    std::vector<Owner> owners_;          // sorted; with slices
    const std::vector<std::uint32_t> acute_;
    PointGrid grid_;
};

}  // namespace

std::size_t conform_pieces(std::vector<Vec3>& points, std::vector<SegmentPiece>& pieces, SegmentGuard& guard,
                           const ConformOptions& options) {
    assert(options.shortest_mm > 0);
    if (pieces.empty()) return 0;
    const std::size_t before = points.size();
    Conformer conformer(points, pieces, guard, options);
    for (int round = 0; round < most_rounds && conformer.split_round(pieces); ++round) {
    }
    return points.size() - before;
}

}  // namespace anatomesh
