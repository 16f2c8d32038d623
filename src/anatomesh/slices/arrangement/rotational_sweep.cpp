#include "anatomesh/slices/arrangement/rotational_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/point_scatter.h"
#include "anatomesh/slices/arrangement/rotation_axis.h"

namespace anatomesh {

namespace {

// It is the angle of a full turn. [rad; 2 pi; D]
constexpr double turn = 2 * std::numbers::pi;
// Two planes have four half-planes, the fewest that follow each other all round. [slices; >= 2; D]
constexpr std::size_t fewest_slices = 2;
// Neighbours are no further apart: half a turn would leave them in one plane. [rad; 0 to pi; D]
constexpr double most_angle = turn * 179 / 360;
// A gap of half a turn or more is none: all slices lie on one side of the axis, and nothing is drawn beyond.
// [rad; pi; D]
constexpr double least_outside = turn / 2;
// Wider gaps are joined by no option: beyond 110 degrees nothing says that the structure goes on.
// [rad; 0 to pi; M 2026-11 planes about an axis that leave a gap]
constexpr double most_joined = turn * 110 / 360;
// Gaps are joined up to this multiple of --max-gap: planes turned by hand differ more than slices of a stack.
// [1; >= 1; M 2026-11 planes about an axis that leave a gap]
constexpr double joined_of_asked = 1.25;
// Narrow gaps are joined up to this multiple of --max-gap: the chord across them is short.
// [1; >= joined_of_asked; M 2026-11 planes about an axis that leave a gap]
constexpr double few_of_asked = 1.75;
// A gap is narrow up to this angle, 31 degrees: 30 and rounding.
// [rad; 0 to most_joined; M 2026-11 planes about an axis that leave a gap]
constexpr double few_joined = turn * 31 / 360;
// What is round the axis goes on over wider gaps, up to 75 degrees: both sides show it.
// [rad; 0 to most_joined; M 2026-11 planes over 130 degrees of a half turn]
constexpr double joined_round_axis = turn * 75 / 360;
// More than this share of the area drawn beside a gap must lie round the axis for that: else two bodies
// beside the axis would be bridged. [1, of an area; 0 to 1; M 2026-11 two bodies by 18 planes]
constexpr double most_round_axis = 0.5;
// A wide gap's angle counts in full from a quarter of it on, the inverse of this: so the clamp changes
// without a step at a slice. [1; >= 2; D]
constexpr double widened = 4;
// An open gap is so many usual heights wider in the chart than it is, so that no search reaches across it.
// [usual heights; >= 1e3; D]
constexpr double open_gap = 1e7;
// Gaps are told of that are wider than so many usual ones, as in a stack. [usual angles; >= 1; C]
constexpr double wide = 1.5;
// Gaps above this angle, 95 degrees, are told of however wide the usual ones are: two planes at right angles
// are none. [rad; pi / 2 to pi; C]
constexpr double always_wide = turn * 95 / 360;
// Half-planes at a smaller angle are one plane that was given twice. [rad; 0 to 1e-3; D rounding of doubles]
constexpr double least_angle = 1e-6;
// A plane that leans more against the axis, by 30 degrees, is no half-plane about it.
// [1, sine; 0 to 1; M 2026-11 planes beside their axis]
constexpr double most_lean = 0.5;
// Up to this distance from the axis neighbours may cross; further out the chart must be one to one.
// [mean radii; > 0; M 2026-11 planes beside their axis]
constexpr double most_crossing = 1;
// More than this share of the neighbours must be apart from there on: a probe off its axis has two gaps where
// its turn ends that never are. [1; 0 to 1; M 2026-11 planes beside their axis]
constexpr double share_apart = 0.5;
// Neighbours are judged on this share of the way along the axis, about its middle: planes that lean part or
// cross near its ends. [1; 0 to 1; M 2026-11 planes that lean by 10 degrees]
constexpr double middle_half = 0.5;
// A plane beside the axis leads away from it from so many of its distances on; nearer it runs along the
// circle about the axis. [distances beside the axis; > 1; M 2026-11 planes beside their axis]
constexpr double off_foot = 1.25;
// If contours of a half-plane reach less far than this share of the median one, it may show the edge of what
// was drawn on the other side. [1; 0 to 1; M 2026-11, set not recorded]
constexpr double least_reach = 0.25;
// Shorter distances are none: they come from rounding. [mean radii; 0 to 1e-3; D rounding of doubles]
constexpr double rounding = 1e-6;
// So many half-planes come again before the first turn and after it, because the curvature of a gap asks for
// slices beyond it. [half-planes; >= 2; D]
constexpr std::ptrdiff_t repeated = 4;

}  // namespace

std::optional<RotationalSweep> RotationalSweep::of(const ContourSet& set, const Axis& axis, double max_gap) {
    if (set.slices.size() < fewest_slices) return std::nullopt;
    RotationalSweep sweep;
    sweep.origin_ = axis.origin;
    sweep.direction_ = axis.direction;
    if (std::any_of(set.slices.begin(), set.slices.end(), [&](const Slice& slice) {
            return std::abs(dot(slice.plane.normal, axis.direction)) > most_lean;
        }))
        return std::nullopt;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3& p : set.points) {
        const double along = dot(p - sweep.origin_, sweep.direction_);
        low = std::min(low, along);
        high = std::max(high, along);
    }
    sweep.mean_radius_ = sweep.mean_radius(set);
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) sweep.add_half_planes(set, s);
    if (!sweep.leave_out_empty() || !sweep.put_in_order(max_gap)) return std::nullopt;
    sweep.find_apart(low, high);
    const double reach = 0.5 * middle_half * (high - low), middle = 0.5 * (low + high);
    std::size_t apart = 0;
    for (std::size_t k = 0; k < sweep.half_planes_.size(); ++k) {
        apart += std::max(sweep.apart_after(k, middle - reach), sweep.apart_after(k, middle + reach)) <=
                 most_crossing * sweep.mean_radius_;
    }
    if (static_cast<double>(apart) <= share_apart * static_cast<double>(sweep.half_planes_.size()))
        return std::nullopt;
    return sweep;
}

// Along the contours, however their vertices are spread.
double RotationalSweep::mean_radius(const ContourSet& set) const {
    double sum = 0, total = 0;
    for (const Contour& contour : set.contours) {
        const auto points = set.points_of(contour);
        for (std::size_t n = 0; n < points.size(); ++n) {
            const Vec3 a = points[n], b = points[(n + 1) % points.size()];
            const double along = length(b - a);
            sum += along * radius(0.5 * (a + b));
            total += along;
        }
    }
    return sum / total;
}

std::vector<RotationalSweep::Gap> RotationalSweep::wide_gaps() const {
    std::vector<Gap> gaps;
    for (std::size_t k = 0; k < half_planes_.size(); ++k) {
        const double angle = angle_after(k);
        if ((angle > wide * usual_angle_ || angle > always_wide) && angle < least_outside)
            gaps.push_back({half_planes_[k].slice, half_planes_[(k + 1) % half_planes_.size()].slice, angle,
                            half_planes_[k].joined});
    }
    return gaps;
}

void RotationalSweep::add_half_planes(const ContourSet& set, std::uint32_t s) {
    const Plane& drawn = set.slices[s].plane;
    for (const bool behind : {false, true}) {
        HalfPlane half{{}, 0, 0, 0, 0, 0, s, behind, 0, 0, 0, true};
        half.plane.normal = behind ? -1.0 * drawn.normal : drawn.normal;
        half.plane.origin = origin_ - drawn.signed_distance(origin_) * drawn.normal;
        half.plane.v = normalized(direction_ - dot(direction_, drawn.normal) * drawn.normal);
        half.plane.u = cross(half.plane.v, half.plane.normal);
        half.beside = -half.plane.signed_distance(origin_);
        half.lean = -dot(direction_, half.plane.normal);
        double area = 0, round_axis = 0;
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            // As to_chart() will find them.
            double inmost = std::numeric_limits<double>::infinity(), outmost = -inmost;
            for (const Vec3& p : set.points_of(contour)) {
                half.low = std::min(half.low, half.plane.signed_distance(p));
                half.high = std::max(half.high, half.plane.signed_distance(p));
                inmost = std::min(inmost, half.plane.to_plane(p).x);
                outmost = std::max(outmost, half.plane.to_plane(p).x);
            }
            half.reach = std::max(half.reach, outmost);
            if (outmost <= 0) continue;
            const double own = vector_area(set.points_of(contour));
            area += own;
            if (inmost < 0) round_axis += own;
        }
        if (area > 0) half.round_axis = round_axis / area;
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
bool RotationalSweep::put_in_order(double max_gap) {
    for (HalfPlane& half : half_planes_) half.angle = angle_of(origin_ + half.plane.u);
    half_planes_.front().angle = 0;
    std::sort(half_planes_.begin() + 1, half_planes_.end(),
              [](const HalfPlane& a, const HalfPlane& b) { return a.angle < b.angle; });
    std::vector<double> angles;
    for (std::size_t k = 0; k < half_planes_.size(); ++k) angles.push_back(angle_after(k));
    std::sort(angles.begin(), angles.end());
    if (angles.front() < least_angle) return false;
    if (angles.back() >= least_outside) angles.pop_back();
    if (angles.empty() || angles.back() > most_angle) return false;
    usual_angle_ = angles[3 * (angles.size() - 1) / 4];  // slices of several passes come in pairs
    if (usual_angle_ > most_joined) return false;
    widest_joined_ = usual_angle_;
    double height = 0;
    for (std::size_t k = 0; k < half_planes_.size(); ++k) {
        HalfPlane& half = half_planes_[k];
        const double angle = angle_after(k);
        const double round_axis =
            std::min(half.round_axis, half_planes_[(k + 1) % half_planes_.size()].round_axis);
        const double asked = max_gap * usual_angle_;
        const double joined_over =
            std::max(joined_of_asked * asked, std::min(few_of_asked * asked, few_joined));
        half.joined = angle <= std::min(joined_over, most_joined) ||
                      (angle <= joined_round_axis && round_axis > most_round_axis);
        if (half.joined) widest_joined_ = std::max(widest_joined_, angle);
        half.height = height;
        height += mean_radius_ * (angle + (half.joined ? 0 : open_gap * usual_angle_));
    }
    turn_height_ = height;
    return true;
}

std::size_t RotationalSweep::before(double angle) const {
    const auto after = std::upper_bound(half_planes_.begin() + 1, half_planes_.end(), angle,
                                        [](double at, const HalfPlane& half) { return at < half.angle; });
    return static_cast<std::size_t>(after - half_planes_.begin()) - 1;
}

double RotationalSweep::angle_after(std::size_t k) const {
    const bool last = k + 1 == half_planes_.size();
    return half_planes_[last ? 0 : k + 1].angle + (last ? turn : 0) - half_planes_[k].angle;
}

// From where on half-planes that have a gap between them, neighbours or not, are half as far apart as their
// angle says, and such as run beside the axis lead away from it: of every gap, at both ends of the axis.
void RotationalSweep::find_apart(double low, double high) {
    low_ = low, high_ = high;
    const std::size_t count = half_planes_.size();
    const auto beside = [&](std::size_t k, bool upper) {
        const HalfPlane& half = half_planes_[k % count];
        return half.beside + (upper ? high : low) * half.lean;
    };
    // Of all that are so many half-planes apart, the widest first: they lie between what is wider.
    std::vector<Ends> wider(count), these(count);
    for (std::size_t span = count / 4 + 1; span > 0; --span) {
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t last = (k + span) % count;
            double angle = half_planes_[last].angle - half_planes_[k].angle;
            if (angle <= 0) angle += turn;
            Ends& ends = these[k];
            beside_ = std::max({beside_, std::abs(beside(k, false)), std::abs(beside(k, true))});
            for (const bool upper : {false, true}) {
                const double first = beside(k, upper), second = beside(last, upper);
                ends[upper] = std::max({2 * (first - second) / angle, wider[k][upper],
                                        wider[(k + count - 1) % count][upper], off_foot * std::abs(first),
                                        off_foot * std::abs(second)});
            }
        }
        wider.swap(these);
    }
    apart_ = std::move(wider);
    if (beside_ <= rounding * mean_radius_) apart_.clear();
}

// So far along the axis; between its ends no less than it is, as it is convex.
double RotationalSweep::apart_after(std::size_t k, double along) const {
    if (apart_.empty()) return 0;
    const double t = std::clamp((along - low_) / (high_ - low_), 0.0, 1.0);
    return apart_[k][0] + t * (apart_[k][1] - apart_[k][0]);
}

double RotationalSweep::angle(Vec3 p) const {
    const double angle = angle_of(p);
    const std::size_t k = before(angle);
    const double here = angle_after(k);
    if (here <= usual_angle_) return usual_angle_;
    const double t = (angle - half_planes_[k].angle) / here;
    return usual_angle_ + std::clamp(widened * std::min(t, 1 - t), 0.0, 1.0) * (here - usual_angle_);
}

double RotationalSweep::apart_from(Vec3 p) const {
    if (apart_.empty()) return 0;
    const std::size_t count = half_planes_.size();
    const double angle = angle_of(p), along = dot(p - origin_, direction_);
    const std::size_t k = before(angle), next = (k + 1) % count;
    const double here = apart_after(k, along);
    const double start = std::max(here, apart_after((k + count - 1) % count, along)),
                 end = std::max(here, apart_after(next, along));
    return start + (angle - half_planes_[k].angle) / angle_after(k) * (end - start);
}

double RotationalSweep::radius(Vec3 p) const {
    return length(cross(p - origin_, direction_));
}

double RotationalSweep::height(std::ptrdiff_t place) const {
    const auto count = static_cast<std::ptrdiff_t>(half_planes_.size());
    const std::ptrdiff_t turns = place < 0 ? -1 : place >= count ? 1 : 0;
    return half_planes_[static_cast<std::size_t>(place - turns * count)].height +
           static_cast<double>(turns) * turn_height_;
}

Vec3 RotationalSweep::to_chart(Vec3 p) const {
    const std::size_t count = half_planes_.size();
    const auto is_past = [&](std::size_t k) {
        return half_planes_[k].plane.signed_distance(p) >= half_planes_[k].low;
    };
    const double angle = angle_of(p);
    std::size_t k = before(angle), next = (k + 1) % count;
    // Where planes run beside the axis it may be one further on or back; never as far as across.
    double gone = angle - half_planes_[k].angle, left = angle_after(k) - gone;
    while (left < turn / 4 && is_past(next)) {
        gone -= angle_after(k);
        k = next;
        next = (k + 1) % count;
        left += angle_after(k);
    }
    while (gone < turn / 4 && !is_past(k)) {
        next = k;
        k = (k + count - 1) % count;
        gone += angle_after(k);
    }
    const HalfPlane &from = half_planes_[k], &to = half_planes_[next];
    const Vec2 q = from.plane.to_plane(p), r = to.plane.to_plane(p);
    const double up = from.plane.signed_distance(p), down = to.plane.signed_distance(p);
    const double beyond = up - from.high, rest = to.low - down;
    const double below = height(static_cast<std::ptrdiff_t>(k)),
                 above = height(static_cast<std::ptrdiff_t>(k + 1));
    if (beyond <= 0 && (from.joined || gone < turn / 4)) return {q.x, q.y, below};
    const double start = std::hypot(q.x, up), end = std::hypot(r.x, down);
    if (!from.joined) {
        const double on = std::atan2(std::abs(beyond), q.x), back = std::atan2(std::abs(rest), r.x);
        if (on <= back) return {start, q.y, below + mean_radius_ * on};
        return {end, r.y, above - mean_radius_ * back};
    }
    const double t = beyond / (beyond + rest);
    return {start + t * (end - start), q.y + t * (r.y - q.y), below + t * (above - below)};
}

ContourSet RotationalSweep::to_chart(const ContourSet& set) const {
    ContourSet result = set;
    result.slices.clear();
    result.contours.clear();
    result.points.clear();
    result.left_out.clear();  // they have no place among those of the chart
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
    return box.grown(reach + 2 * farthest * std::sin(0.25 * widest_joined_));
}

}  // namespace anatomesh
