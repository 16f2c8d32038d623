#include "anatomesh/reconcile/regularize/regularize_fans.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/contour/overlay/slice_soundness.h"
#include "anatomesh/reconcile/move/contour_graph.h"
#include "anatomesh/reconcile/move/reindex_points.h"
#include "anatomesh/reconcile/regularize/axis_limits.h"

namespace anatomesh {

namespace {

// A direction with a smaller share across the line runs along it.
// [1, sine; 0 to 1; M 2026-11 69 random sets about an axis]
constexpr double least_across = 0.1;
// With a smaller share across the line it is not known in which half plane a ray lies.
// [1, sine; 0 to 1; M 2026-11 thin shell by 15 planes]
constexpr double no_half_plane = 0.01;
// A ray is turned up to this share of the way to the next point that must stay.
// [1; 0 to 0.5; M 2026-11 69 random sets about an axis]
constexpr double share_of_way = 1.0 / 3;
// A smaller share of the radius asked for leaves no room for a vertex. [1; 0 to 1; M 2026-11, set not
// recorded]
constexpr double least_radius_share = 0.02;
// A ray with room for a smaller share of the radius is no bound to the others.
// [1; 0 to 1; M 2026-11 69 random sets about an axis]
constexpr double short_ray_share = 0.5;
// A vertex up to so many radii away is the ray's end. [radii; >= 1; M 2026-11 69 random sets about an axis]
constexpr double vertex_near = 1.3;
// A ray that would turn by less stays as it is. [degrees; >= 0; M 2026-11 69 random sets about an axis]
constexpr double least_turn_degrees = 3;

double degrees(double radians) {
    return radians * 180 / std::numbers::pi;
}

// A point of a contour at a pole.
struct Visit {
    Vec3 at;
    std::uint32_t slice = 0, structure = 0, contour = 0, point = 0;
};

struct InsertedPoint {
    Vec3 at, was;
};

struct Ray {
    std::uint32_t slice = 0, contour = 0, pole = 0;  // pole: point of the set
    bool forward = true;
    std::vector<std::uint32_t> inside;  // points of the set up to the radius, going out
    bool ends_on_vertex = false;        // the last of these; else between it and the next
    Vec3 end;
    Vec3 radial;                              // unit vector across the line, in the half plane
    double drawn_latitude = 0, latitude = 0;  // of its end over that, radians; before and after
    double azimuth = 0;                       // of the half plane, radians
    bool held = false;
};

class FanRegularization {
  public:
    FanRegularization(ContourSet& set, OriginalPositions& drawn, const FanOptions& options)
        : set_(set), drawn_(drawn), options_(options), graph_(make_contour_graph(set)) {}

    FanStats run() {
        find_places();
        moved_ = set_.points;
        put_in_.resize(set_.points.size());
        for (const auto& visits : places_) regularize(visits);
        if (stats_.fans > 0) lay_out();
        if (stats_.highest_mm == 0) stats_.fans = 0;
        return stats_;
    }

  private:
    // Groups the points of all contours by place.
    void find_places() {
        for (std::uint32_t c = 0; c < set_.contours.size(); ++c) {
            const Contour& contour = set_.contours[c];
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k)
                visits_.push_back({set_.points[k], contour.slice, contour.structure, c, k});
        }
        std::sort(visits_.begin(), visits_.end(), [](const Visit& p, const Visit& q) {
            if (p.at != q.at) return lexicographic_less(p.at, q.at);
            return std::pair(p.structure, p.point) < std::pair(q.structure, q.point);
        });
        for (std::size_t first = 0, last = 0; first < visits_.size(); first = last) {
            while (last < visits_.size() && visits_[last].at == visits_[first].at) ++last;
            places_.push_back(std::span(visits_).subspan(first, last - first));
        }
        stays_ = points_that_stay(set_, graph_);
    }

    // Returns the direction of the line that the planes of all visits share.
    std::optional<Vec3> common_line(std::span<const Visit> visits) const {
        std::vector<std::uint32_t> slices;
        for (const Visit& visit : visits) slices.push_back(visit.slice);
        sort_distinct(slices);
        if (slices.size() < planes_at_axis) return {};
        const Vec3 first = set_.slices[slices.front()].plane.normal;
        Vec3 line;
        for (const std::uint32_t slice : slices) {
            const Vec3 other = cross(first, set_.slices[slice].plane.normal);
            if (squared_length(other) > squared_length(line)) line = other;
        }
        if (!(squared_length(line) > 0)) return {};
        line = normalized(line);
        for (const std::uint32_t slice : slices) {
            if (std::abs(dot(line, set_.slices[slice].plane.normal)) > same_axis_sine) return {};
        }
        return line;
    }

    void regularize(std::span<const Visit> visits) {
        if (visits.size() < planes_at_axis) return;
        const std::optional<Vec3> line = common_line(visits);
        if (!line) return;
        const double radius = radius_at(visits);
        if (!(radius >= least_radius_share * options_.radius_mm)) return;
        const std::size_t before = ways_.size();
        for (std::size_t first = 0; first < visits.size();) {
            std::size_t last = first;
            while (last < visits.size() && visits[last].structure == visits[first].structure) ++last;
            std::optional<std::vector<Ray>> fan = fan_of(visits.subspan(first, last - first), *line, radius);
            if (fan && turn(*fan, *line)) {
                for (const Ray& ray : *fan) {
                    if (degrees(std::abs(ray.latitude - ray.drawn_latitude)) >= least_turn_degrees)
                        ways_.emplace(key_of(ray), direction(ray, *line));
                }
            }
            first = last;
        }
        // A ray moves for every structure that has it, or for none.
        for (const bool moves : {false, true}) {
            for (const Visit& visit : visits) {
                for (const bool forward : {false, true}) {
                    if (room_of(visit, forward) < radius) continue;
                    const Ray ray = ray_of(visit, forward, radius);
                    const auto found = ways_.find(key_of(ray));
                    if (found == ways_.end()) continue;
                    if (moves) {
                        move(ray, found->second);
                    } else if (goes_too_far(ray, found->second)) {
                        ways_.erase(found);
                    }
                }
            }
        }
        stats_.fans += ways_.size() > before;
    }

    std::uint32_t next(const Contour& contour, std::uint32_t point, bool forward) const {
        return forward ? point_after(contour, point) : point_before(contour, point);
    }

    // Returns the straight distance to the next point that stays, or three radii where that is further.
    double way_to_next(const Visit& visit, bool forward) const {
        const Contour& contour = set_.contours[visit.contour];
        const double far = options_.radius_mm / share_of_way;
        for (std::uint32_t k = next(contour, visit.point, forward);; k = next(contour, k, forward)) {
            const double distance = length(set_.points[k] - visit.at);
            if (k == visit.point || stays_[k]) return std::min(distance, far);
            if (distance >= far) return far;
        }
    }

    double room_of(const Visit& visit, bool forward) const {
        return share_of_way * way_to_next(visit, forward);
    }

    // Returns a radius for which half of the rays or more have room, or the least room where fewer have
    // enough.
    double radius_at(std::span<const Visit> visits) const {
        double least = options_.radius_mm, radius = options_.radius_mm;
        std::size_t with_room = 0;
        for (const Visit& visit : visits) {
            for (const bool forward : {false, true}) {
                const double room = room_of(visit, forward);
                least = std::min(least, room);
                if (room < short_ray_share * options_.radius_mm) continue;
                radius = std::min(radius, room);
                ++with_room;
            }
        }
        return with_room >= visits.size() ? radius : least;
    }

    // Returns one ray in every half plane, by azimuth, or nothing where the contours are not so.
    std::optional<std::vector<Ray>> fan_of(std::span<const Visit> visits, Vec3 line, double radius) const {
        std::vector<Ray> fan;
        const Vec3 across = set_.slices[visits.front().slice].plane.normal, along = cross(line, across);
        for (const Visit& visit : visits) {
            for (const bool forward : {false, true}) {
                // A ray reaches up to a point that stays, however near, because it may turn elsewhere
                // there.
                const double room = std::min(radius, room_of(visit, forward));
                if (!(room > 0)) return {};
                Ray ray = ray_of(visit, forward, room);
                const Vec3 way = normalized(ray.end - visit.at);
                const Vec3 radial = way - dot(way, line) * line;
                if (length(radial) < no_half_plane) return {};
                ray.radial = cross(set_.slices[visit.slice].plane.normal, line);
                if (dot(ray.radial, radial) < 0) ray.radial = -1 * ray.radial;
                ray.radial = normalized(ray.radial);
                ray.drawn_latitude = ray.latitude = std::atan2(dot(way, line), dot(way, ray.radial));
                ray.azimuth = std::atan2(dot(ray.radial, along), dot(ray.radial, across));
                if (const auto found = ways_.find(key_of(ray)); found != ways_.end()) {
                    ray.latitude = std::atan2(dot(found->second, line), dot(found->second, ray.radial));
                    ray.held = true;
                }
                ray.held = ray.held || room < radius;
                fan.push_back(std::move(ray));
            }
        }
        if (fan.size() < 2 * planes_at_axis) return {};
        std::sort(fan.begin(), fan.end(), [](const Ray& p, const Ray& q) { return p.azimuth < q.azimuth; });
        for (std::size_t n = 0; n < fan.size(); ++n) {
            const Ray& other = fan[(n + 1) % fan.size()];
            if (fan[n].slice == other.slice && dot(fan[n].radial, other.radial) > 0) return {};
        }
        return fan;
    }

    Ray ray_of(const Visit& visit, bool forward, double radius) const {
        Ray ray;
        ray.slice = visit.slice;
        ray.contour = visit.contour;
        ray.pole = visit.point;
        ray.forward = forward;
        const Contour& contour = set_.contours[visit.contour];
        Vec3 from = visit.at;
        for (std::uint32_t k = next(contour, visit.point, forward);; k = next(contour, k, forward)) {
            const Vec3 at = set_.points[k];
            const double distance = length(at - visit.at);
            if (distance < vertex_near * radius) ray.inside.push_back(k);
            if (distance >= radius) {
                ray.ends_on_vertex = distance < vertex_near * radius;
                ray.end = ray.ends_on_vertex ? at : crossing(visit.at, from, at, radius);
                return ray;
            }
            from = at;
        }
    }

    // Returns where the way from p, within the radius, to q leaves the ball.
    static Vec3 crossing(Vec3 centre, Vec3 p, Vec3 q, double radius) {
        const Vec3 way = q - p, from = p - centre;
        const double a = squared_length(way), b = dot(way, from), c = squared_length(from) - radius * radius;
        const double t = (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
        return p + std::clamp(t, 0.0, 1.0) * way;
    }

    static Vec3 direction(const Ray& ray, Vec3 line) {
        return std::cos(ray.latitude) * ray.radial + std::sin(ray.latitude) * line;
    }

    // Returns the angle at a ray between the facets to its neighbours, degrees.
    static double angle_at(Vec3 before, Vec3 ray, Vec3 after) {
        const Vec3 p = cross(ray, before), q = cross(ray, after);
        return degrees(std::atan2(length(cross(p, q)), dot(p, q)));
    }

    static bool is_sharp(const std::vector<Vec3>& ways, double least) {
        const std::size_t n = ways.size();
        for (std::size_t k = 0; k < n; ++k) {
            if (angle_at(ways[(k + n - 1) % n], ways[k], ways[(k + 1) % n]) < least) return true;
        }
        return false;
    }

    // Turns rays that are too steep. Returns whether there was one.
    bool turn_steep(std::vector<Ray>& fan) const {
        const double most = options_.steepest_degrees * std::numbers::pi / 180;
        bool turned = false;
        for (Ray& ray : fan) {
            if (ray.held || degrees(std::abs(ray.latitude) - most) < least_turn_degrees) continue;
            ray.latitude = std::copysign(most, ray.latitude);
            turned = true;
        }
        return turned;
    }

    // Turns the rays of a fan until none is sharp. Returns whether a ray was turned.
    bool turn(std::vector<Ray>& fan, Vec3 line) const {
        const std::size_t n = fan.size();
        std::vector<Vec3> ways(n);
        bool turned = turn_steep(fan);
        for (int step = 0; step < most_regularizing_steps; ++step) {
            for (std::size_t k = 0; k < n; ++k) ways[k] = direction(fan[k], line);
            if (!is_sharp(ways, options_.least_degrees)) break;
            turned = true;
            for (std::size_t k = 0; k < n; ++k) {
                Ray& ray = fan[k];
                const Ray &before = fan[(k + n - 1) % n], &after = fan[(k + 1) % n];
                double gap = degrees(after.azimuth - before.azimuth);
                if (gap < 0) gap += 360;
                if (ray.held || gap > widest_gap_degrees) continue;
                Vec3 way = cross(cross(ways[(k + n - 1) % n], ways[(k + 1) % n]),
                                 set_.slices[ray.slice].plane.normal);
                if (dot(way, ray.radial) < 0) way = -1 * way;
                if (dot(way, ray.radial) < least_across * length(way)) continue;
                ray.latitude += 0.5 * (std::atan2(dot(way, line), dot(way, ray.radial)) - ray.latitude);
            }
        }
        return turned;
    }

    // Structures that share a wall share its rays, so rays are named by nodes.
    std::pair<std::uint32_t, std::uint32_t> key_of(const Ray& ray) const {
        return {graph_.node_of_point[ray.pole],
                graph_.node_of_point[next(set_.contours[ray.contour], ray.pole, ray.forward)]};
    }

    Vec3 turned(const Ray& ray, Vec3 at, Vec3 way) const {
        const Vec3 pole = set_.points[ray.pole];
        return pole + length(at - pole) * way;
    }

    bool goes_too_far(const Ray& ray, Vec3 way) const {
        if (length(turned(ray, ray.end, way) - ray.end) > options_.most_moved_mm) return true;
        return std::any_of(ray.inside.begin(), ray.inside.end(), [&](std::uint32_t k) {
            return length(turned(ray, set_.points[k], way) - drawn_.at[k]) > options_.most_moved_mm;
        });
    }

    void move(const Ray& ray, Vec3 way) {
        for (const std::uint32_t k : ray.inside) moved_[k] = turned(ray, set_.points[k], way);
        if (ray.ends_on_vertex) return;
        const std::uint32_t last = ray.inside.empty() ? ray.pole : ray.inside.back();
        const std::uint32_t from = ray.forward ? last : point_before(set_.contours[ray.contour], last);
        put_in_[from].push_back({turned(ray, ray.end, way), ray.end});
    }

    void lay_out() {
        std::vector<std::vector<Vec3>> fresh(set_.contours.size());
        OriginalPositions drawn;
        for (const Slice& slice : set_.slices) {
            std::vector<PlaneRing> rings;
            const std::uint32_t end = slice.first_contour + slice.contour_count;
            for (std::uint32_t c = slice.first_contour; c < end; ++c) {
                fresh[c] = points_of(set_.contours[c]);
                PlaneRing ring{set_.contours[c].structure, {}};
                for (const Vec3& p : fresh[c]) ring.at.push_back(slice.plane.to_plane(p));
                rings.push_back(std::move(ring));
            }
            if (slice_faults(rings, set_.exclusive).empty()) continue;
            for (std::uint32_t c = slice.first_contour; c < end; ++c) {
                restore(set_.contours[c]);
                fresh[c] = points_of(set_.contours[c]);
            }
        }
        for (std::uint32_t c = 0; c < set_.contours.size(); ++c) {
            const Contour& contour = set_.contours[c];
            for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
                drawn.at.push_back(drawn_.at[k]);
                drawn.is_drawn.push_back(drawn_.is_drawn[k]);
                stats_.highest_mm = std::max(stats_.highest_mm, length(moved_[k] - set_.points[k]));
                for (const InsertedPoint& point : ordered(k)) {
                    drawn.at.push_back(point.was);
                    drawn.is_drawn.push_back(false);
                    stats_.highest_mm = std::max(stats_.highest_mm, length(point.at - point.was));
                }
            }
        }
        reindex_points(set_, fresh);
        drawn_ = std::move(drawn);
    }

    // Of two poles' points on one segment the nearer comes first.
    std::vector<InsertedPoint> ordered(std::uint32_t k) const {
        std::vector<InsertedPoint> points = put_in_[k];
        std::sort(points.begin(), points.end(), [&](const InsertedPoint& p, const InsertedPoint& q) {
            return squared_length(p.was - set_.points[k]) < squared_length(q.was - set_.points[k]);
        });
        return points;
    }

    std::vector<Vec3> points_of(const Contour& contour) const {
        std::vector<Vec3> points;
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            points.push_back(moved_[k]);
            for (const InsertedPoint& point : ordered(k)) points.push_back(point.at);
        }
        return points;
    }

    void restore(const Contour& contour) {
        for (std::uint32_t k = contour.first_point; k < contour.first_point + contour.point_count; ++k) {
            moved_[k] = set_.points[k];
            put_in_[k].clear();
        }
    }

    ContourSet& set_;
    OriginalPositions& drawn_;
    const FanOptions& options_;
    const ContourGraph graph_;
    FanStats stats_;
    std::vector<Visit> visits_;  // by place, then by structure
    std::vector<std::span<const Visit>> places_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> ways_;  // of rays that were turned
    std::vector<bool> stays_;                                       // per point of the set
    std::vector<Vec3> moved_;                                       // the same
    std::vector<std::vector<InsertedPoint>> put_in_;                // after the point
};

}  // namespace

FanStats regularize_fans(ContourSet& set, OriginalPositions& drawn, const FanOptions& options) {
    assert(options.radius_mm > 0 && options.least_degrees > 0 && options.least_degrees < 180);
    assert(options.steepest_degrees > 0 && options.steepest_degrees <= 90);
    assert(drawn.at.size() == set.points.size());
    return FanRegularization(set, drawn, options).run();
}

}  // namespace anatomesh
