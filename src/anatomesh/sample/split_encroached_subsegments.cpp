#include "anatomesh/sample/split_encroached_subsegments.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

#include "anatomesh/base/parallel.h"
#include "anatomesh/geom/point_grid.h"
#include "anatomesh/sample/segment_clusters.h"

namespace anatomesh {

namespace {

// Encroached subsegments are split so often. [rounds; >= 1; B]
constexpr int most_rounds = 24;
// A subsegment is not split where a vertex is this near.
// [shortest lengths; 0 to 1; M 2026-11 fetal brain and crossing stacks]
constexpr double near_share = 0.5;
// A vertex on the sphere of a ball is not in it. [radii; 0 to 1; D rounding of doubles]
constexpr double in_ball = 1 - 1e-9;
constexpr double cell_share = 1.5;  // A cell of the grid. [mean lengths of subsegments; > 0; B]
// So many subsegments are looked at in one task. [subsegments at a time; >= 1; B]
constexpr std::size_t grain = 512;
// It stands for no vertex. [index that no vertex has; 0xFFFFFFFF; D]
constexpr std::uint32_t no_vertex = 0xFFFFFFFFu;

using VertexPair = std::array<std::uint32_t, 2>;
using Owner = std::array<std::uint32_t, 2>;  // a point, and a structure with a contour through it

class EncroachedSubsegments {
  public:
    EncroachedSubsegments(std::vector<Vec3>& points, const std::vector<Subsegment>& subsegments,
                          ProtectedSegments& protected_segments, const EncroachmentOptions& options)
        : points_(points),
          protected_segments_(protected_segments),
          shortest_(options.shortest_mm),
          grading_{options.growth, options.growth > 0 ? options.shortest_graded_mm / (2 * options.growth) : 0,
                   options.shortest_mm, options.shortest_mm},
          threads_(options.threads),
          slices_(options.slices),
          acute_(acute_vertices(points, subsegments)),
          apexes_(slices_.empty() ? SegmentClusters(points, subsegments, acute_) : SegmentClusters()),
          cell_size_(cell_share * mean_length(points, subsegments)),
          grid_(cell_size_, points.size()),
          fresh_(cell_size_, 0) {
        for (const Vec3& p : points) grid_.add(p);
        if (slices_.empty()) return;
        for (const Subsegment& subsegment : subsegments) {
            owners_.push_back({subsegment.a, subsegment.structure});
            owners_.push_back({subsegment.b, subsegment.structure});
        }
        std::sort(owners_.begin(), owners_.end());
    }

    // From now on subsegments are graded down to this length.
    void grade_to(double shortest) {
        grading_.shortest_before = grading_.shortest;
        grading_.shortest = shortest;
    }

    // Says whether any was split.
    bool split_round(std::vector<Subsegment>& subsegments) {
        const std::vector<Want> wants = find_wants(subsegments);
        const std::size_t first_new = points_.size();
        fresh_ = PointGrid(cell_size_, 0);
        std::vector<Subsegment> next;
        // Subsegments of several structures with one ball follow each other.
        for (std::size_t n = 0, last = 0; n < subsegments.size(); n = last) {
            while (last < subsegments.size() && subsegments[last].ball == subsegments[n].ball) ++last;
            const std::optional<Vec3> at = place_of_split(subsegments[n], wants[n]);
            if (!at) {
                next.insert(next.end(), subsegments.begin() + n, subsegments.begin() + last);
                continue;
            }
            const auto v = static_cast<std::uint32_t>(points_.size());
            points_.push_back(*at);
            fresh_.add(*at);
            if (!slices_.empty()) {
                slices_.push_back(slices_[subsegments[n].a]);
                for (std::size_t k = n; k < last; ++k) owners_.push_back({v, subsegments[k].structure});
            }
            protected_segments_.drop_ball(subsegments[n].ball);
            const std::uint32_t low = protected_segments_.add_segment(points_[subsegments[n].a], *at);
            const std::uint32_t high = protected_segments_.add_segment(*at, points_[subsegments[n].b]);
            apexes_.pass_on(subsegments[n], low, high);
            for (std::size_t k = n; k < last; ++k)
                next.push_back({subsegments[k].a, v, subsegments[k].structure, low});
            for (std::size_t k = n; k < last; ++k)
                next.push_back({v, subsegments[k].b, subsegments[k].structure, high});
        }
        for (std::size_t n = first_new; n < points_.size(); ++n) {
            grid_.add(points_[n]);
            protected_segments_.add_point(points_[n]);
        }
        subsegments = std::move(next);
        first_fresh_ = first_new;
        grading_.shortest_before = grading_.shortest;
        return points_.size() > first_new;
    }

  private:
    // How much longer than the next vertex beside them subsegments may be, and down to which length.
    struct Grading {
        double growth;           // 0: they are not graded
        double room;             // no vertex is nearer to a place of split; mm
        double shortest;         // so far; mm
        double shortest_before;  // in the last round; mm
    };

    // Why a subsegment should be split.
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
        return ProtectedSegments::any_within(grid_, p, room, apex) ||
               ProtectedSegments::any_within(fresh_, p, room, apex);
    }

    // If nothing is too near there. Where planes cross on shells, on which all that meet at an apex may be
    // split side by side: were every other one split, those between would have vertices in their balls for
    // good.
    std::optional<Vec3> place_of_split(const Subsegment& subsegment, const Want& want) const {
        if (want.any()) {
            const double room = near_share * shortest_;
            if (const std::optional<std::uint32_t> apex = apexes_.of(subsegment)) {
                const Vec3 at = shell_point(points_, subsegment, points_[*apex]);
                if (!is_taken(at, room, points_[*apex])) return at;
                return std::nullopt;
            }
            const Vec3 at = split_point(points_, subsegment, acute_);
            if (want.encroached && !is_taken(at, room)) return at;
            if (want.ungraded && !is_taken(at, grading_.room) && !is_in_corner(at, subsegment)) return at;
        }
        if (want.beside == no_vertex) return std::nullopt;
        const Vec3 beside = points_[want.beside];
        const std::optional<Vec3> foot = foot_on(points_, subsegment, beside);
        if (!foot || is_taken(*foot, foot_room * length(beside - *foot))) return std::nullopt;
        return foot;
    }

    // Of the first subsegment of each ball.
    std::vector<Want> find_wants(const std::vector<Subsegment>& subsegments) {
        if (grading_.growth > 0) find_neighbors(subsegments);
        std::vector<Want> wants(subsegments.size());
        parallel_for(subsegments.size(), grain, threads_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                if (n > 0 && subsegments[n - 1].ball == subsegments[n].ball) continue;
                std::size_t last = n + 1;
                while (last < subsegments.size() && subsegments[last].ball == subsegments[n].ball) ++last;
                if (may_have_changed(subsegments[n])) {
                    const std::span<const Subsegment> all = std::span(subsegments).subspan(n, last - n);
                    wants[n] = {is_encroached(all), is_ungraded(subsegments[n]), vertex_beside(all)};
                }
            }
        });
        return wants;
    }

    // Since the last round: a subsegment that was to stay, or could not be split, is looked at again when a
    // point came near it, or shorter ones may be graded. (What is in its way stays.)
    bool may_have_changed(const Subsegment& subsegment) const {
        if (subsegment.a >= first_fresh_ || subsegment.b >= first_fresh_) return true;
        const Vec3 a = points_[subsegment.a], way = points_[subsegment.b] - a;
        const double span = length(way);
        if (span < 2 * grading_.shortest_before && span >= 2 * grading_.shortest) return true;
        return fresh_.any_within(a + 0.5 * way,
                                 grading_.growth > 0 ? span * (0.5 + 1 / grading_.growth) : 0.5 * span);
    }

    static double mean_length(const std::vector<Vec3>& points, const std::vector<Subsegment>& subsegments) {
        double total = 0;
        for (const Subsegment& subsegment : subsegments)
            total += length(points[subsegment.b] - points[subsegment.a]);
        return total / static_cast<double>(subsegments.size());
    }

    // Subsegments of one ball. Of what is nearer than points may lie only what shells can keep apart.
    bool is_encroached(std::span<const Subsegment> all) const {
        const Subsegment& subsegment = all[0];
        const Vec3 a = points_[subsegment.a], way = points_[subsegment.b] - a;
        const double span = length(way);
        if (span < 2 * shortest_) return false;
        const std::optional<std::uint32_t> apex = apexes_.of(subsegment);
        bool found = false;
        grid_.for_each_within(a + 0.5 * way, 0.5 * in_ball * span, [&](std::uint32_t v, double) {
            if (found || v == subsegment.a || v == subsegment.b || !counts(v, all)) return;
            const double distance = length(cross(way, points_[v] - a)) / span;
            found = distance > near_share * shortest_ ||
                    (apex && distance > ProtectedSegments::least_angle * length(points_[v] - points_[*apex]));
        });
        return found;
    }

    void find_neighbors(const std::vector<Subsegment>& subsegments) {
        neighbors_.clear();
        for (const Subsegment& subsegment : subsegments) {
            neighbors_.push_back({subsegment.a, subsegment.b});
            neighbors_.push_back({subsegment.b, subsegment.a});
        }
        std::sort(neighbors_.begin(), neighbors_.end());
    }

    // Whether another vertex of the slice is nearer to the subsegment than its length allows. At a small
    // angle the next vertices on both sides are as near as they may be.
    bool is_ungraded(const Subsegment& subsegment) const {
        if (!(grading_.growth > 0)) return false;
        const Vec3 a = points_[subsegment.a], way = points_[subsegment.b] - a;
        const double span = length(way), reach = span / grading_.growth;
        if (span < 2 * grading_.shortest) return false;
        bool found = false;
        grid_.for_each_within(a + 0.5 * way, 0.5 * span + reach, [&](std::uint32_t v, double) {
            if (found || v == subsegment.a || v == subsegment.b || slices_[v] != slices_[subsegment.a])
                return;
            const double share = std::clamp(dot(points_[v] - a, way) / (span * span), 0.0, 1.0);
            if (squared_length(points_[v] - (a + share * way)) >= reach * reach) return;
            found = !is_next(v, subsegment);
        });
        return found;
    }

    // Whether a subsegment that meets this one at a small angle is nearer to a point on it than graded points
    // may lie to each other: that one could not follow, and would have the point in its ball.
    bool is_in_corner(Vec3 at, const Subsegment& subsegment) const {
        const auto next_is_near = [&](std::uint32_t end) {
            auto n = std::lower_bound(neighbors_.begin(), neighbors_.end(), VertexPair{end, 0});
            for (; n != neighbors_.end() && (*n)[0] == end; ++n) {
                const std::uint32_t v = (*n)[1];
                if (v == subsegment.a || v == subsegment.b || !is_next(v, subsegment)) continue;
                const Vec3 way = points_[v] - points_[end], to = at - points_[end];
                if (dot(to, way) < squared_length(way) &&
                    length(cross(way, to)) < grading_.room * length(way))
                    return true;
            }
            return false;
        };
        return next_is_near(subsegment.a) || next_is_near(subsegment.b);
    }

    // Whether a subsegment to v meets this one at a small angle.
    bool is_next(std::uint32_t v, const Subsegment& subsegment) const {
        const auto at = [&](std::uint32_t end, std::uint32_t other) {
            return std::binary_search(neighbors_.begin(), neighbors_.end(), VertexPair{end, v}) &&
                   dot(points_[v] - points_[end], points_[other] - points_[end]) > 0;
        };
        return at(subsegment.a, subsegment.b) || at(subsegment.b, subsegment.a);
    }

    // A vertex in the ball of these subsegments that grading does not heed: the next at a small angle, or one
    // too near. Of several the one nearest to the middle.
    std::uint32_t vertex_beside(std::span<const Subsegment> all) const {
        const Vec3 a = points_[all[0].a], way = points_[all[0].b] - a;
        const double span = length(way);
        std::uint32_t found = no_vertex;
        if (!(grading_.growth > 0) || span < 2 * grading_.shortest) return found;
        double nearest = HUGE_VAL;
        grid_.for_each_within(a + 0.5 * way, 0.5 * in_ball * span, [&](std::uint32_t v, double squared) {
            if (v == all[0].a || v == all[0].b || !counts(v, all)) return;
            if (length(cross(way, points_[v] - a)) >= grading_.room * span && !is_next(v, all[0])) return;
            if (squared > nearest || (squared == nearest && v > found)) return;
            nearest = squared;
            found = v;
        });
        return found;
    }

    bool counts(std::uint32_t v, std::span<const Subsegment> all) const {
        if (slices_.empty()) return true;
        if (slices_[v] != slices_[all[0].a]) return false;
        return std::none_of(all.begin(), all.end(), [&](const Subsegment& subsegment) {
            return std::binary_search(owners_.begin(), owners_.end(), Owner{v, subsegment.structure});
        });
    }

    std::vector<Vec3>& points_;
    ProtectedSegments& protected_segments_;
    const double shortest_;
    Grading grading_;
    std::size_t first_fresh_ = 0;  // the first point of the last round
    const int threads_;
    std::vector<std::uint32_t> slices_;  // by point, or empty
    std::vector<Owner> owners_;          // sorted; with slices
    std::vector<VertexPair> neighbors_;  // sorted: ends of subsegments, both ways; with grading_.growth
    const std::vector<std::uint32_t> acute_;
    SegmentClusters apexes_;  // of none within slices
    const double cell_size_;
    PointGrid grid_, fresh_;  // of all points, and of those of the last round
};

}  // namespace

std::size_t split_encroached_subsegments(std::vector<Vec3>& points, std::vector<Subsegment>& subsegments,
                                         ProtectedSegments& protected_segments,
                                         const EncroachmentOptions& options) {
    assert(options.shortest_mm > 0);
    if (subsegments.empty()) return 0;
    const std::size_t before = points.size();
    EncroachedSubsegments encroached(points, subsegments, protected_segments, options);
    const auto split_all = [&] {
        for (int round = 0; round < most_rounds && encroached.split_round(subsegments); ++round) {
        }
    };
    split_all();
    if (!(options.growth > 0)) return points.size() - before;
    // Step by step: outlines that run beside each other all the way must not ask for many times the points.
    for (double shortest = options.shortest_mm;
         shortest > options.shortest_graded_mm &&
         static_cast<double>(points.size()) <= (1 + options.most_added) * static_cast<double>(before);) {
        shortest = std::max(0.5 * shortest, options.shortest_graded_mm);
        encroached.grade_to(shortest);
        split_all();
    }
    return points.size() - before;
}

}  // namespace anatomesh
