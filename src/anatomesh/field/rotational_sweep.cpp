#include "anatomesh/field/rotational_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "anatomesh/contour/point_scatter.h"
#include "anatomesh/geom/box.h"

namespace anatomesh {

namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr std::size_t fewest_slices = 2;
constexpr double most_angle = turn * 110 / 360, most_of_median = 2.5;  // between neighbours
constexpr double wide = 1.5;                                           // of the median, that is told of
constexpr double least_angle = 1e-3;                           // less is one plane
constexpr double most_crossing = 0.5;   // of the mean radius: up to there neighbours may cross
constexpr double least_reach = 0.25;    // of half-planes, of the median one
constexpr double rounding = 1e-6;       // of the mean radius
constexpr std::ptrdiff_t repeated = 4;  // half-planes before the first turn and after it

// The point nearest to all planes, in the sense of least squares, across `direction` from `near`.
Vec3 nearest_to_planes(const ContourSet& set, Vec3 near, Vec3 direction) {
    const Plane across = make_plane(near, direction);
    double uu = 0, uv = 0, vv = 0, ud = 0, vd = 0;
    for (const Slice& slice : set.slices) {
        const double u = dot(slice.plane.normal, across.u), v = dot(slice.plane.normal, across.v);
        const double d = slice.plane.signed_distance(near);
        uu += u * u, uv += u * v, vv += v * v;
        ud += u * d, vd += v * d;
    }
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) return near;
    return across.to_space({(uv * vd - vv * ud) / determinant, (uv * ud - uu * vd) / determinant});
}

}  // namespace

std::optional<RotationalSweep> RotationalSweep::of(const ContourSet& set) {
    if (set.slices.size() < fewest_slices) return std::nullopt;
    RotationalSweep sweep;
    Scatter normals;
    for (const Slice& slice : set.slices) normals.add(slice.plane.normal);
    sweep.direction_ = least_direction(normals);
    const Box3 box = set.box();
    sweep.origin_ = nearest_to_planes(set, 0.5 * (box.low + box.high), sweep.direction_);
    double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0;
    for (const Vec3& p : set.points) {
        const double along = dot(p - sweep.origin_, sweep.direction_);
        low = std::min(low, along);
        high = std::max(high, along);
        sum += sweep.radius(p);
    }
    sweep.mean_radius_ = sum / static_cast<double>(set.points.size());
    double beside = 0;  // a plane from the axis, as far as contours reach along it
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        for (const double along : {low, high}) {
            const Vec3 end = sweep.origin_ + along * sweep.direction_;
            beside = std::max(beside, std::abs(set.slices[s].plane.signed_distance(end)));
        }
        sweep.add_half_planes(set, s);
    }
    if (!sweep.leave_out_empty() || !sweep.put_in_order()) return std::nullopt;
    sweep.apart_from_ = 4 * beside / sweep.least_angle_;
    if (!(sweep.apart_from_ <= most_crossing * sweep.mean_radius_)) return std::nullopt;
    return sweep;
}

std::vector<RotationalSweep::Gap> RotationalSweep::wide_gaps() const {
    std::vector<Gap> gaps;
    for (std::size_t k = 0; k < half_planes_.size(); ++k) {
        const bool last = k + 1 == half_planes_.size();
        const HalfPlane &from = half_planes_[k], &to = half_planes_[last ? 0 : k + 1];
        const double angle = to.angle + (last ? turn : 0) - from.angle;
        if (angle > wide * median_angle_) gaps.push_back({from.slice, to.slice, angle});
    }
    return gaps;
}

void RotationalSweep::add_half_planes(const ContourSet& set, std::uint32_t s) {
    const Plane& drawn = set.slices[s].plane;
    for (const bool behind : {false, true}) {
        HalfPlane half{{}, 0, 0, 0, s, behind, 0};
        half.plane.normal = behind ? -1.0 * drawn.normal : drawn.normal;
        half.plane.origin = origin_ - drawn.signed_distance(origin_) * drawn.normal;
        half.plane.v = normalized(direction_ - dot(direction_, drawn.normal) * drawn.normal);
        half.plane.u = cross(half.plane.v, half.plane.normal);
        // As straight() will find them.
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            for (const Vec3& p : set.points_of(contour)) {
                half.low = std::min(half.low, half.plane.signed_distance(p));
                half.high = std::max(half.high, half.plane.signed_distance(p));
                half.reach = std::max(half.reach, half.plane.to_plane(p).x);
            }
        }
        half_planes_.push_back(half);
    }
}

// Half-planes on which nothing is drawn. Returns whether all others are drawn far out: one with little on it
// may be half of a slice that was drawn on its other half alone, and tell nothing of what is further out.
bool RotationalSweep::leave_out_empty() {
    const double nothing = rounding * mean_radius_;
    std::erase_if(half_planes_, [&](const HalfPlane& half) { return half.reach <= nothing; });
    if (half_planes_.empty()) return false;
    std::vector<double> reaches;
    for (const HalfPlane& half : half_planes_) reaches.push_back(half.reach);
    std::sort(reaches.begin(), reaches.end());
    return reaches.front() >= least_reach * reaches[reaches.size() / 2];
}

double RotationalSweep::angle_of(Vec3 p) const {
    const Plane& first = half_planes_.front().plane;
    const Vec3 way = p - origin_;
    const double angle = std::atan2(dot(way, first.normal), dot(way, first.u));
    return angle < 0 ? angle + turn : angle;
}

// Returns whether they follow each other all round.
bool RotationalSweep::put_in_order() {
    for (HalfPlane& half : half_planes_) half.angle = angle_of(origin_ + half.plane.u);
    half_planes_.front().angle = 0;
    std::sort(half_planes_.begin() + 1, half_planes_.end(),
              [](const HalfPlane& a, const HalfPlane& b) { return a.angle < b.angle; });
    std::vector<double> angles;
    for (std::size_t k = 0; k + 1 < half_planes_.size(); ++k)
        angles.push_back(half_planes_[k + 1].angle - half_planes_[k].angle);
    angles.push_back(half_planes_.front().angle + turn - half_planes_.back().angle);
    std::sort(angles.begin(), angles.end());
    least_angle_ = angles.front();
    median_angle_ = angles[angles.size() / 2];
    widest_angle_ = angles.back();
    return least_angle_ >= least_angle &&
           widest_angle_ <= std::min(most_angle, most_of_median * median_angle_);
}

double RotationalSweep::radius(Vec3 p) const {
    return length(cross(p - origin_, direction_));
}

double RotationalSweep::height(std::ptrdiff_t place) const {
    const auto count = static_cast<std::ptrdiff_t>(half_planes_.size());
    const std::ptrdiff_t turns = place < 0 ? -1 : place >= count ? 1 : 0;
    return mean_radius_ * (half_planes_[static_cast<std::size_t>(place - turns * count)].angle +
                           static_cast<double>(turns) * turn);
}

Vec3 RotationalSweep::straight(Vec3 p) const {
    const std::size_t count = half_planes_.size();
    const auto is_past = [&](std::size_t k) {
        return half_planes_[k].plane.signed_distance(p) >= half_planes_[k].low;
    };
    const auto after =
        std::upper_bound(half_planes_.begin() + 1, half_planes_.end(), angle_of(p),
                         [](double angle, const HalfPlane& half) { return angle < half.angle; });
    auto k = static_cast<std::size_t>(after - half_planes_.begin()) - 1;
    // Where planes run beside the axis its neighbour may be the one.
    std::size_t next = (k + 1) % count;
    if (is_past(next)) {
        k = next;
        next = (k + 1) % count;
    } else if (!is_past(k)) {
        next = k;
        k = (k + count - 1) % count;
    }
    const HalfPlane &from = half_planes_[k], &to = half_planes_[next];
    const Vec2 q = from.plane.to_plane(p), r = to.plane.to_plane(p);
    const double up = from.plane.signed_distance(p), down = to.plane.signed_distance(p);
    const double beyond = up - from.high;
    const double below = height(static_cast<std::ptrdiff_t>(k));
    if (beyond <= 0) return {q.x, q.y, below};
    const double t = beyond / (beyond + (to.low - down));
    const double start = std::hypot(q.x, up), end = std::hypot(r.x, down);
    return {start + t * (end - start), q.y + t * (r.y - q.y),
            below + t * (height(static_cast<std::ptrdiff_t>(k + 1)) - below)};
}

ContourSet RotationalSweep::straight(const ContourSet& set) const {
    ContourSet result = set;
    result.slices.clear();
    result.contours.clear();
    result.points.clear();
    const auto count = static_cast<std::ptrdiff_t>(half_planes_.size());
    const std::ptrdiff_t more = std::min(repeated, count);
    for (std::ptrdiff_t place = -more; place < count + more; ++place) {
        const HalfPlane& half = half_planes_[static_cast<std::size_t>((place + count) % count)];
        const double z = height(place);
        Slice slice = set.slices[half.slice];
        slice.plane = {{0, 0, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        if (half.behind) {
            slice.plane.v = {0, -1, 0};
            slice.plane.normal = {0, 0, -1};
        }
        slice.first_contour = static_cast<std::uint32_t>(result.contours.size());
        for (Contour contour : set.contours_of(set.slices[half.slice])) {
            const auto points = set.points_of(contour);
            contour.slice = static_cast<std::uint32_t>(result.slices.size());
            contour.first_point = static_cast<std::uint32_t>(result.points.size());
            for (const Vec3& p : points) {
                const Vec2 q = half.plane.to_plane(p);
                result.points.push_back({q.x, q.y, z});
            }
            result.contours.push_back(contour);
        }
        result.slices.push_back(std::move(slice));
    }
    return result;
}

Box3 RotationalSweep::around(const Box3& box, double reach) const {
    double farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p{(corner & 1 ? box.high : box.low).x, (corner & 2 ? box.high : box.low).y,
                     (corner & 4 ? box.high : box.low).z};
        farthest = std::max(farthest, radius(p));
    }
    // Turned into the nearest slice a point moves by so much.
    return box.grown(reach + 2 * farthest * std::sin(0.25 * widest_angle_));
}

}  // namespace anatomesh
