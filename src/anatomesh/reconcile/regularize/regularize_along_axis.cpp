#include "anatomesh/reconcile/regularize/regularize_along_axis.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/reindex_points.h"
#include "anatomesh/reconcile/regularize/axis_limits.h"
#include "anatomesh/slices/lines/arc.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

namespace {

// What is further from the line than so many radii counts as being that far.
// [radii; > 1; M 2026-11 69 random sets about an axis]
constexpr double reach_radii = 4;
// A shift by a smaller share of the distance from the line is not worth a change.
// [1; 0 to 1; M 2026-11 69 random sets about an axis]
constexpr double least_shift_share = 0.1;
// Shares of a segment that differ by less are one place. [1; > 0; D]
constexpr double same_share = 1e-9;

double radians(double degrees) {
    return degrees * std::numbers::pi / 180;
}

struct AxisOfPlanes {
    Line line;
    std::vector<std::uint32_t> slices;  // of planes through it
};

// Returns the lines that four planes or more contain.
std::vector<AxisOfPlanes> find_axes(const ContourSet& set) {
    const auto count = static_cast<std::uint32_t>(set.slices.size());
    std::vector<AxisOfPlanes> axes;
    const auto is_known = [&](std::uint32_t a, std::uint32_t b) {
        return std::any_of(axes.begin(), axes.end(), [&](const AxisOfPlanes& axis) {
            return std::binary_search(axis.slices.begin(), axis.slices.end(), a) &&
                   std::binary_search(axis.slices.begin(), axis.slices.end(), b);
        });
    };
    const Vec3 near = set.box().low;
    for (std::uint32_t a = 0; a < count; ++a) {
        for (std::uint32_t b = a + 1; b < count; ++b) {
            const Plane &p = set.slices[a].plane, &q = set.slices[b].plane;
            if (length(cross(p.normal, q.normal)) <= same_axis_sine || is_known(a, b)) continue;
            const Line line = common_line(p, q, near);
            std::vector<std::uint32_t> through;
            for (std::uint32_t c = 0; c < count; ++c) {
                const Plane& plane = set.slices[c].plane;
                if (std::abs(dot(plane.normal, line.direction)) <= same_axis_sine &&
                    std::abs(plane.signed_distance(line.origin)) <= beside_plane_mm)
                    through.push_back(c);
            }
            if (through.size() >= planes_at_axis) axes.push_back({line, std::move(through)});
        }
    }
    return axes;
}

// A point of a contour beside the line, by how far it is along the line and from it. It is a point of the
// set, or lies at a share of the segment from there to the next one.
struct AlongAxisPoint {
    double along = 0, from_line = 0;
    std::uint32_t point = no_node;
    double share = 0;                 // 0: that point
    std::uint32_t low = 0, high = 0;  // the half plane's points at that segment's ends
    double drawn_from_line = 0;       // before it was moved
    bool may_move = false;
};

struct AlongAxisSegment {
    std::uint32_t a = 0, b = 0;  // indices into a half plane's points
};

// Holds what a structure has beside the line, on one side of it in a plane.
struct HalfPlane {
    std::uint32_t slice = 0;
    Vec3 outward;        // unit vector across the line
    double azimuth = 0;  // radians
    std::vector<AlongAxisPoint> points;
    std::vector<AlongAxisSegment> segments;

    // Returns how far from the line the first contour is at a place of the line.
    double first_at(double along, double farthest) const {
        double first = farthest;
        for (const AlongAxisSegment& segment : segments) {
            const AlongAxisPoint &a = points[segment.a], &b = points[segment.b];
            if (std::min(a.along, b.along) > along || std::max(a.along, b.along) < along) continue;
            const double way = b.along - a.along;
            const double share = way != 0 ? (along - a.along) / way : 0;
            first = std::min(first, a.from_line + share * (b.from_line - a.from_line));
        }
        return first;
    }
};

class AxisRegularization {
  public:
    AxisRegularization(const ContourSet& set, const AxisOfPlanes& axis, std::uint32_t structure,
                       const AlongAxisBounds& most_mm, const AlongAxisOptions& options,
                       const std::vector<bool>& stays)
        : set_(set), axis_(axis), most_mm_(most_mm), options_(options), stays_(stays) {
        const Vec3 across = set.slices[axis.slices.front()].plane.normal,
                   along = cross(axis.line.direction, across);
        for (const std::uint32_t slice : axis.slices) {
            const Vec3 out = normalized(cross(set.slices[slice].plane.normal, axis.line.direction));
            for (const double side : {1.0, -1.0}) {
                HalfPlane half;
                half.slice = slice;
                half.outward = side * out;
                half.azimuth = std::atan2(dot(half.outward, along), dot(half.outward, across));
                gather(half, structure);
                halves_.push_back(std::move(half));
            }
        }
        std::sort(halves_.begin(), halves_.end(),
                  [](const HalfPlane& p, const HalfPlane& q) { return p.azimuth < q.azimuth; });
    }

    const std::vector<HalfPlane>& halves() const { return halves_; }

    // Returns whether anything was moved.
    bool run() {
        bool any = false;
        for (int step = 0; step < most_regularizing_steps; ++step) {
            std::vector<Move> moves;
            for (std::size_t h = 0; h < halves_.size(); ++h) find_moves(h, moves);
            if (moves.empty()) break;
            any = true;
            for (const Move& move : moves) halves_[move.half].points[move.point].from_line = move.to;
        }
        return any;
    }

  private:
    struct Move {
        std::size_t half = 0, point = 0;
        double to = 0;
    };

    void gather(HalfPlane& half, std::uint32_t structure) const {
        for (const Contour& contour : set_.contours_of(set_.slices[half.slice])) {
            if (contour.structure != structure) continue;
            std::vector<std::uint32_t> index(contour.point_count, no_node);
            const auto vertex = [&](std::uint32_t k) {
                std::uint32_t& n = index[k - contour.first_point];
                if (n == no_node) {
                    n = static_cast<std::uint32_t>(half.points.size());
                    const Vec2 at = place(half, k);
                    half.points.push_back({at.x, at.y, k, 0, n, n, at.y, false});
                }
                return n;
            };
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                const std::uint32_t next = point_after(contour, k);
                const Vec2 a = place(half, k), b = place(half, next);
                if (std::min(a.y, b.y) >= reach_radii * options_.radius_mm || (a.y < 0 && b.y < 0)) continue;
                const std::uint32_t low = vertex(k), high = vertex(next);
                add_segment(half, low, high);
            }
        }
    }

    Vec2 place(const HalfPlane& half, std::uint32_t k) const {
        return {axis_.line.along(set_.points[k]), dot(set_.points[k] - axis_.line.origin, half.outward)};
    }

    // Adds a segment, with points about a radius apart where it is near the line.
    void add_segment(HalfPlane& half, std::uint32_t low, std::uint32_t high) const {
        const AlongAxisPoint from = half.points[low], to = half.points[high];
        const Vec2 a{from.along, from.from_line}, b{to.along, to.from_line};
        const double radius = options_.radius_mm;
        const bool is_along_axis = std::abs(b.y - a.y) <= steepest_along_line * std::abs(b.x - a.x) &&
                                   std::min(a.y, b.y) < radius && std::min(a.y, b.y) > -beside_plane_mm;
        if (!is_along_axis) {
            half.segments.push_back({low, high});
            return;
        }
        for (const std::uint32_t n : {low, high}) {
            AlongAxisPoint& end = half.points[n];
            end.may_move = end.from_line > 0 && end.from_line < radius && !stays_[end.point] &&
                           !is_near_another_plane(half, {end.along, end.from_line});
        }
        const int parts = std::max(1, static_cast<int>(std::ceil(length(b - a) / radius)));
        std::uint32_t last = low;
        for (int n = 1; n < parts; ++n) {
            const double share = static_cast<double>(n) / parts;
            const Vec2 at = a + share * (b - a);
            const auto next = static_cast<std::uint32_t>(half.points.size());
            const bool may_move = at.y < radius && !is_near_another_plane(half, at);
            half.points.push_back({at.x, at.y, from.point, share, low, high, at.y, may_move});
            half.segments.push_back({last, next});
            last = next;
        }
        half.segments.push_back({last, high});
    }

    // Near another plane contours meet those of its slice, so they stay there.
    bool is_near_another_plane(const HalfPlane& half, Vec2 at) const {
        const Vec3 p = axis_.line.at(at.x) + at.y * half.outward;
        for (std::uint32_t s = 0; s < set_.slices.size(); ++s) {
            if (!std::binary_search(axis_.slices.begin(), axis_.slices.end(), s) &&
                std::abs(set_.slices[s].plane.signed_distance(p)) < options_.radius_mm)
                return true;
        }
        return false;
    }

    void find_moves(std::size_t h, std::vector<Move>& moves) const {
        const std::size_t count = halves_.size();
        const HalfPlane &half = halves_[h], &before = halves_[(h + count - 1) % count],
                        &after = halves_[(h + 1) % count];
        const auto gap = [](const HalfPlane& p, const HalfPlane& q) {
            const double way = q.azimuth - p.azimuth;
            return way < 0 ? way + 2 * std::numbers::pi : way;
        };
        const double back = gap(before, half), on = gap(half, after);
        if (back + on > radians(widest_gap_degrees)) return;
        const double radius = options_.radius_mm, far = reach_radii * radius;
        for (const AlongAxisSegment& segment : half.segments) {
            const Vec2 way{half.points[segment.b].along - half.points[segment.a].along,
                           half.points[segment.b].from_line - half.points[segment.a].from_line};
            for (const std::uint32_t n : {segment.a, segment.b}) {
                const AlongAxisPoint& point = half.points[n];
                if (!point.may_move || point.from_line >= radius ||
                    half.first_at(point.along, far) < point.from_line - beside_plane_mm)
                    continue;
                const double p = before.first_at(point.along, far), q = after.first_at(point.along, far);
                if (!(p > 0) || !(q > 0) || !is_sharp(point.from_line, way, p, back, q, on)) continue;
                const double chord = p * q * std::sin(back + on) / (p * std::sin(back) + q * std::sin(on));
                const double to = std::min(radius, point.from_line + 0.5 * (chord - point.from_line)),
                             most = most_mm_[half.slice];
                const double within =
                    std::clamp(to, point.drawn_from_line - most, point.drawn_from_line + most);
                if (within != point.from_line) moves.push_back({h, n, within});
            }
        }
    }

    // Returns whether the angle at a stretch, between the ways to those beside it, is too small. The stretch
    // runs on by `way` (along, from the line).
    bool is_sharp(double from_line, Vec2 way, double before, double back, double after, double on) const {
        const Vec3 edge = normalized({way.x, way.y, 0});
        const auto to = [&](double r, double azimuth) {
            const Vec3 p{0, r * std::cos(azimuth) - from_line, r * std::sin(azimuth)};
            return p - dot(p, edge) * edge;
        };
        const Vec3 p = to(before, -back), q = to(after, on);
        return std::atan2(length(cross(p, q)), dot(p, q)) < radians(options_.least_degrees);
    }

    const ContourSet& set_;
    const AxisOfPlanes& axis_;
    const AlongAxisBounds& most_mm_;
    const AlongAxisOptions& options_;
    const std::vector<bool>& stays_;
    std::vector<HalfPlane> halves_;
};

class AlongAxisRegularization {
  public:
    AlongAxisRegularization(ContourSet& set, OriginalPositions& drawn, const AlongAxisBounds& most_mm,
                            const AlongAxisOptions& options)
        : set_(set), drawn_(drawn), most_mm_(most_mm), options_(options), graph_(make_contour_graph(set)) {}

    AlongAxisStats run() {
        const std::vector<AxisOfPlanes> axes = find_axes(set_);
        if (axes.empty()) return {};
        stays_ = points_that_stay(set_, graph_);
        moved_.assign(graph_.point_of_node.size(), Vec3{});
        put_in_.resize(graph_.segments.size());
        for (const AxisOfPlanes& axis : axes) {
            for (std::uint32_t s = 0; s < set_.structures.size(); ++s) {
                AxisRegularization regularization(set_, axis, s, most_mm_, options_, stays_);
                if (regularization.run()) take(regularization.halves());
            }
        }
        if (any_) lay_out();
        return stats_;
    }

  private:
    // A point that is put into a segment of the graph.
    struct InsertedAlongAxis {
        double share = 0;  // of the way from its lower node
        Vec3 at, was;
        double by_mm = 0;
    };

    // Takes over what moved enough, on contours that no earlier structure has moved there.
    void take(const std::vector<HalfPlane>& halves) {
        for (const HalfPlane& half : halves) {
            for (const AlongAxisPoint& point : half.points) {
                const AlongAxisPoint &low = half.points[point.low], &high = half.points[point.high];
                const double without = point.share > 0
                                           ? low.from_line + point.share * (high.from_line - low.from_line)
                                           : point.drawn_from_line;
                if (!(std::abs(point.from_line - without) >= least_shift_share * without)) continue;
                const Vec3 way = (point.from_line - point.drawn_from_line) * half.outward;
                if (length(way) > options_.most_moved_mm) continue;
                if (point.share > 0) {
                    put_in(point, way);
                } else {
                    move(point, way);
                }
                any_ = true;
            }
        }
    }

    void move(const AlongAxisPoint& point, Vec3 way) {
        Vec3& moved = moved_[graph_.node_of_point[point.point]];
        const Vec3 to = set_.points[point.point] + way;
        if (moved != Vec3{} || length(to - drawn_.at[point.point]) > options_.most_moved_mm) return;
        moved = way;
    }

    void put_in(const AlongAxisPoint& point, Vec3 way) {
        const std::uint32_t segment = graph_.segment_of_point[point.point];
        const auto [low, high] = graph_.segments[segment];
        const double share = graph_.node_of_point[point.point] == low ? point.share : 1 - point.share;
        std::vector<InsertedAlongAxis>& all = put_in_[segment];
        if (std::any_of(all.begin(), all.end(), [&](const InsertedAlongAxis& put) {
                return std::abs(put.share - share) < same_share;
            }))
            return;
        const std::uint32_t a = graph_.point_of_node[low], b = graph_.point_of_node[high];
        all.push_back({share, set_.points[a] + share * (set_.points[b] - set_.points[a]) + way,
                       drawn_.at[a] + share * (drawn_.at[b] - drawn_.at[a]), length(way)});
    }

    struct Laid {
        std::vector<Vec3> points, drawn;
        std::vector<bool> is_drawn;
    };

    Laid laid(const Contour& contour, bool changed) const {
        Laid result;
        const auto add = [&](Vec3 at, Vec3 drawn, bool is_drawn) {
            result.points.push_back(at);
            result.drawn.push_back(drawn);
            result.is_drawn.push_back(is_drawn);
        };
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            const std::uint32_t node = graph_.node_of_point[k], segment = graph_.segment_of_point[k];
            add(changed ? set_.points[k] + moved_[node] : set_.points[k], drawn_.at[k], drawn_.is_drawn[k]);
            if (!changed) continue;
            std::vector<InsertedAlongAxis> between = put_in_[segment];
            const bool upwards = graph_.segments[segment][0] == node;
            std::sort(between.begin(), between.end(),
                      [&](const InsertedAlongAxis& p, const InsertedAlongAxis& q) {
                          return upwards ? p.share < q.share : p.share > q.share;
                      });
            for (const InsertedAlongAxis& put : between) add(put.at, put.was, false);
        }
        return result;
    }

    void count(const Contour& contour) {
        const auto add = [&](double by) {
            stats_.points += by > 0;
            stats_.farthest_mm = std::max(stats_.farthest_mm, by);
        };
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            add(length(moved_[graph_.node_of_point[k]]));
            for (const InsertedAlongAxis& put : put_in_[graph_.segment_of_point[k]]) add(put.by_mm);
        }
    }

    void lay_out() {
        std::vector<std::vector<Vec3>> fresh(set_.contours.size());
        OriginalPositions drawn;
        for (const Slice& slice : set_.slices) {
            const std::uint32_t end = slice.first_contour + slice.contour_count;
            std::vector<PlaneRing> rings;
            for (std::uint32_t c = slice.first_contour; c < end; ++c) {
                PlaneRing ring{set_.contours[c].structure, {}};
                for (const Vec3& p : laid(set_.contours[c], true).points)
                    ring.at.push_back(slice.plane.to_plane(p));
                rings.push_back(std::move(ring));
            }
            const bool is_sound = slice_faults(rings, set_.exclusive).empty();
            for (std::uint32_t c = slice.first_contour; c < end; ++c) {
                Laid contour = laid(set_.contours[c], is_sound);
                if (is_sound) count(set_.contours[c]);
                fresh[c] = std::move(contour.points);
                drawn.at.insert(drawn.at.end(), contour.drawn.begin(), contour.drawn.end());
                drawn.is_drawn.insert(drawn.is_drawn.end(), contour.is_drawn.begin(), contour.is_drawn.end());
            }
        }
        reindex_points(set_, fresh);
        drawn_ = std::move(drawn);
    }

    ContourSet& set_;
    OriginalPositions& drawn_;
    const AlongAxisBounds& most_mm_;
    const AlongAxisOptions& options_;
    const ContourGraph graph_;
    AlongAxisStats stats_;
    bool any_ = false;
    std::vector<bool> stays_;                             // per point of the set
    std::vector<Vec3> moved_;                             // per node: by how much
    std::vector<std::vector<InsertedAlongAxis>> put_in_;  // per segment
};

}  // namespace

AlongAxisStats regularize_along_axis(ContourSet& set, OriginalPositions& drawn,
                                     const AlongAxisBounds& most_mm, const AlongAxisOptions& options) {
    assert(options.radius_mm > 0 && options.least_degrees > 0 && options.least_degrees < 180);
    assert(drawn.at.size() == set.points.size());
    assert(most_mm.size() == set.slices.size());
    return AlongAxisRegularization(set, drawn, most_mm, options).run();
}

}  // namespace anatomesh
