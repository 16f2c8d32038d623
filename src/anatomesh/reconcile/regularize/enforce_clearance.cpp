#include "anatomesh/reconcile/regularize/enforce_clearance.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "anatomesh/contour/overlay/segment_index.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/geom/polygon.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/reindex_points.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

namespace {

// What moves away from one contour may come near another, so that passes are made, so many at most.
// [passes; >= 1; B]
constexpr int most_passes = 4;
// Contours nearer than this share of the clearance nearly touch. [1; 0 to 1; M 2026-11 69 random sets about
// an axis]
constexpr double nearly_touching = 0.5;

// A point of a contour as it is worked on.
struct Point {
    Vec3 at, drawn;
    Vec2 here, was;  // the same in the slice's plane
    bool is_drawn = false;
};

struct Loop {
    std::uint32_t structure = 0;
    std::vector<Point> points;
    const Point& after(std::size_t n) const { return points[n + 1 < points.size() ? n + 1 : 0]; }
};

// A vertex that nearly touches a segment.
struct Touch {
    std::size_t loop = 0, vertex = 0, other = 0, segment = 0;
};

// The nearest place of a segment, as a share of its length, and its distance.
struct Foot {
    double share = 0, distance = 0;
    Vec2 at;
};

Foot foot_of(Vec2 p, Vec2 a, Vec2 b) {
    const double square = squared_length(b - a);
    const double share = square > 0 ? std::clamp(dot(p - a, b - a) / square, 0.0, 1.0) : 0;
    const Vec2 at = a + share * (b - a);
    return {share, length(p - at), at};
}

class SliceClearance {
  public:
    SliceClearance(const ContourSet& set, const OriginalPositions& drawn, std::uint32_t slice,
                   double least_mm)
        : set_(set), slice_(slice), plane_(set.slices[slice].plane), least_mm_(least_mm) {
        for (const Contour& contour : set.contours_of(set.slices[slice])) {
            Loop loop{contour.structure, {}};
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
                loop.points.push_back(make_point(set.points[k], drawn.at[k], drawn.is_drawn[k]));
            loops_.push_back(std::move(loop));
        }
    }

    ClearanceStats run() {
        for (int pass = 0; pass < most_passes; ++pass) {
            bool any = false;
            for (const Touch& touch : touches()) any |= part(touch);
            if (!any) break;
        }
        return kept_;
    }

    const std::vector<Loop>& loops() const { return loops_; }

  private:
    Point make_point(Vec3 at, Vec3 drawn, bool is_drawn) const {
        return {at, drawn, plane_.to_plane(at), plane_.to_plane(drawn), is_drawn};
    }

    // Returns how far apart the two are to be, or 0 where they are far enough.
    double wanted(const Point& v, const Point& a, const Point& b) const {
        const double was = foot_of(v.was, a.was, b.was).distance;
        if (was < nearly_touching * least_mm_) return 0;  // drawn so
        const double least = std::min(least_mm_, was);
        return foot_of(v.here, a.here, b.here).distance < nearly_touching * least ? least : 0;
    }

    bool is_touch(const Touch& touch) const {
        const Loop &loop = loops_[touch.loop], &other = loops_[touch.other];
        if (loop.structure != other.structure && !set_.exclusive) return false;
        const Point &v = loop.points[touch.vertex], &a = other.points[touch.segment],
                    &b = other.after(touch.segment);
        if (v.at == a.at || v.at == b.at) return false;
        // A vertex near the end of its own segment is a short segment, and no touch.
        const Foot foot = foot_of(v.here, a.here, b.here);
        const Vec3 before = loop.points[touch.vertex > 0 ? touch.vertex - 1 : loop.points.size() - 1].at,
                   after = loop.after(touch.vertex).at;
        if (foot.share == 0 && (a.at == before || a.at == after)) return false;
        if (foot.share == 1 && (b.at == before || b.at == after)) return false;
        return wanted(v, a, b) > 0;
    }

    std::vector<Touch> touches() const {
        std::vector<Segment2> boxes;
        std::vector<std::pair<std::size_t, std::size_t>> places;
        for (std::size_t l = 0; l < loops_.size(); ++l) {
            for (std::size_t n = 0; n < loops_[l].points.size(); ++n) {
                const Vec2 a = loops_[l].points[n].here, b = loops_[l].after(n).here;
                const Vec2 margin{least_mm_, least_mm_};
                boxes.push_back({Vec2{std::min(a.x, b.x), std::min(a.y, b.y)} - margin,
                                 Vec2{std::max(a.x, b.x), std::max(a.y, b.y)} + margin});
                places.emplace_back(l, n);
            }
        }
        std::vector<Touch> found;
        SegmentIndex(boxes).for_each_near_pair([&](std::uint32_t i, std::uint32_t j) {
            for (const auto& [v, s] : {std::pair{i, j}, std::pair{j, i}}) {
                const Touch touch{places[v].first, places[v].second, places[s].first, places[s].second};
                if (is_touch(touch)) found.push_back(touch);
            }
            return true;
        });
        std::sort(found.begin(), found.end(), [](const Touch& p, const Touch& q) {
            return std::tie(p.loop, p.vertex, p.other, p.segment) <
                   std::tie(q.loop, q.vertex, q.other, q.segment);
        });
        return found;
    }

    bool lies_in_another_plane(Vec3 p) const {
        for (std::uint32_t s = 0; s < set_.slices.size(); ++s) {
            if (s != slice_ && std::abs(set_.slices[s].plane.signed_distance(p)) <= beside_plane_mm)
                return true;
        }
        return false;
    }

    bool part(const Touch& touch) {
        // An earlier touch may have changed this one, or put a vertex in.
        if (touch.vertex >= loops_[touch.loop].points.size() ||
            touch.segment >= loops_[touch.other].points.size() || !is_touch(touch))
            return false;
        const Point v = loops_[touch.loop].points[touch.vertex],
                    a = loops_[touch.other].points[touch.segment],
                    b = loops_[touch.other].after(touch.segment);
        const Foot foot = foot_of(v.here, a.here, b.here);
        const double by = wanted(v, a, b) - foot.distance;
        if (!(foot.distance > 0)) return false;
        const Vec2 away = (by / foot.distance) * (v.here - foot.at);
        const std::vector<Loop> before = loops_;
        if (!lies_in_another_plane(v.at)) {
            move(v.at, v.at + away.x * plane_.u + away.y * plane_.v);
        } else if (foot.share > 0 && foot.share < 1) {
            Point between = make_point(plane_.to_space(foot.at - away),
                                       a.drawn + foot.share * (b.drawn - a.drawn), false);
            put_in(a.at, b.at, between);
        } else {
            return false;
        }
        if (!is_sound()) {
            loops_ = before;
            return false;
        }
        ++kept_.places;
        kept_.farthest_mm = std::max(kept_.farthest_mm, by);
        return true;
    }

    void move(Vec3 from, Vec3 to) {
        for (Loop& loop : loops_) {
            for (Point& point : loop.points) {
                if (point.at == from) point.at = to, point.here = plane_.to_plane(to);
            }
        }
    }

    void put_in(Vec3 a, Vec3 b, const Point& between) {
        for (Loop& loop : loops_) {
            for (std::size_t n = 0; n < loop.points.size(); ++n) {
                const Vec3 p = loop.points[n].at, q = loop.after(n).at;
                if (!((p == a && q == b) || (p == b && q == a))) continue;
                loop.points.insert(loop.points.begin() + static_cast<std::ptrdiff_t>(n) + 1, between);
                ++n;
            }
        }
    }

    bool is_sound() const {
        std::vector<PlaneRing> rings;
        for (const Loop& loop : loops_) {
            PlaneRing ring{loop.structure, {}};
            for (const Point& point : loop.points) ring.at.push_back(point.here);
            rings.push_back(std::move(ring));
        }
        return slice_faults(rings, set_.exclusive).empty();
    }

    const ContourSet& set_;
    const std::uint32_t slice_;
    const Plane& plane_;
    const double least_mm_;
    std::vector<Loop> loops_;
    ClearanceStats kept_;
};

}  // namespace

ClearanceStats enforce_clearance(ContourSet& set, OriginalPositions& drawn, double least_mm) {
    assert(least_mm > 0);
    ClearanceStats kept;
    std::vector<std::vector<Vec3>> points(set.contours.size());
    OriginalPositions now;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        SliceClearance clearance(set, drawn, s, least_mm);
        const ClearanceStats of_slice = clearance.run();
        kept.places += of_slice.places;
        kept.farthest_mm = std::max(kept.farthest_mm, of_slice.farthest_mm);
        std::size_t c = set.slices[s].first_contour;
        for (const Loop& loop : clearance.loops()) {
            for (const Point& point : loop.points) {
                points[c].push_back(point.at);
                now.at.push_back(point.drawn);
                now.is_drawn.push_back(point.is_drawn);
            }
            ++c;
        }
    }
    if (kept.places == 0) return kept;
    reindex_points(set, points);
    drawn = std::move(now);
    return kept;
}

}  // namespace anatomesh
