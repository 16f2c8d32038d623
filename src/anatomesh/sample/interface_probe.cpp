#include "anatomesh/sample/interface_probe.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace anatomesh {

namespace {

// A point is projected onto several surfaces one after the other, so often, [rounds; >= 1; B]
constexpr int focus_rounds = 6;
// until no surface is farther than so many tolerances. [tolerances; >= 1; M 2026-11, set not recorded]
constexpr double focus_slack = 10;
constexpr double everywhere = std::numeric_limits<double>::infinity();  // as a reach

}  // namespace

double InterfaceProbe::single_value(Vec3 p, double reach) {
    if (p == looked_at_) return seen_;
    const double value = field_.value_within(0, p, reach);
    if (std::abs(value) <= reach) {
        looked_at_ = p;
        seen_ = value;
    }
    return value;
}

const std::vector<std::uint32_t>& InterfaceProbe::members(Vec3 p) {
    members_.clear();
    if (single_) {
        if (single_value(p, 0) < 0) members_.push_back(0);
    } else {
        field_.members(p, members_);
    }
    return members_;
}

void InterfaceProbe::focus_between(const std::vector<std::uint32_t>& here,
                                   const std::vector<std::uint32_t>& there) {
    focus_.clear();
    if (single_ || field_.exclusive()) return;
    std::set_symmetric_difference(here.begin(), here.end(), there.begin(), there.end(),
                                  std::back_inserter(focus_));
}

double InterfaceProbe::distance(Vec3 p, double reach) {
    if (single_) return std::abs(single_value(p, reach));
    if (focus_.empty()) return field_.interface_distance(p);
    double farthest = 0;
    for (const std::uint32_t s : focus_) farthest = std::max(farthest, std::abs(field_.value(s, p)));
    return farthest;
}

InterfaceProbe::Look InterfaceProbe::look(Vec3 p, double reach) {
    if (!single_) {
        const double distance = field_.members_and_distance(p, members_);
        return {members_, distance};
    }
    const double value = single_value(p, reach);
    members_.clear();
    if (value < 0) members_.push_back(0);
    return {members_, std::abs(value)};
}

double InterfaceProbe::fix_side(Vec3 p) {
    if (single_ || !focus_.empty()) {
        const double value = single_ ? single_value(p, everywhere) : field_.value(surface_, p);
        sign_ = value < 0 ? -1 : 1;
        return std::abs(value);
    }
    const Look there = look(p);
    side_ = there.members;
    return there.distance;
}

double InterfaceProbe::side_distance(Vec3 p) {
    if (single_ || !focus_.empty()) return sign_ * field_.value(surface_, p);
    const Look there = look(p);
    return there.members == side_ ? there.distance : -there.distance;
}

// Illinois method: regula falsi that halves the weight of an end kept twice (Dowell and Jarratt, BIT 11, 1971).
Vec3 InterfaceProbe::crossing_between(Vec3 p, Vec3 q, double at_p, double at_q, double tolerance) {
    double low = 0, high = 1;
    const double span = length(q - p);
    for (int step = 0; step < 30 && (high - low) * span > tolerance; ++step) {
        double t = at_p - at_q > 0 ? low + (high - low) * at_p / (at_p - at_q) : 0.5 * (low + high);
        if (!(t > low && t < high) || step % 4 == 3) t = 0.5 * (low + high);
        const double value = side_distance(p + t * (q - p));
        if (std::abs(value) < 0.2 * tolerance) return p + t * (q - p);
        if (value > 0) {
            low = t;
            at_p = value;
            at_q *= 0.5;
        } else {
            high = t;
            at_q = value;
            at_p *= 0.5;
        }
    }
    return p + 0.5 * (low + high) * (q - p);
}

std::optional<Vec3> InterfaceProbe::project(Vec3 p, double max_move, double tolerance) {
    if (single_ || focus_.empty()) return project_one(p, max_move, tolerance);
    Vec3 at = p;
    for (int round = 0; round < focus_rounds; ++round) {
        for (const std::uint32_t surface : focus_) {
            if (focus_.size() > 1 && std::abs(field_.value(surface, at)) <= tolerance) continue;
            surface_ = surface;
            const std::optional<Vec3> onto = project_one(at, max_move, tolerance);
            if (!onto) return std::nullopt;
            at = *onto;
        }
        if (focus_.size() == 1) return at;
        if (distance(at) <= tolerance) break;
    }
    if (distance(at) > focus_slack * tolerance || length(at - p) > max_move) return std::nullopt;
    return at;
}

std::optional<Vec3> InterfaceProbe::project_one(Vec3 p, double max_move, double tolerance) {
    const double here = fix_side(p);
    // Where the distance falls fastest, by differences over a step that stays on this side where it can.
    const double delta = std::max(tolerance, 0.25 * here);
    const Vec3 gradient{side_distance(p + Vec3{delta, 0, 0}) - here,
                        side_distance(p + Vec3{0, delta, 0}) - here,
                        side_distance(p + Vec3{0, 0, delta}) - here};
    const double steepness = length(gradient);
    if (!(steepness > 0)) return std::nullopt;
    const Vec3 direction = (-1.0 / steepness) * gradient;

    double near = 0, at_near = here;
    for (double reach = std::max(1.05 * here, tolerance); near < max_move; reach *= 1.6) {
        const double far = std::min(reach, max_move);
        const double at_far = side_distance(p + far * direction);
        if (at_far <= 0) {
            return crossing_between(p + near * direction, p + far * direction, at_near, at_far, tolerance);
        }
        near = far;
        at_near = at_far;
    }
    return std::nullopt;
}

std::optional<Vec3> InterfaceProbe::first_crossing(Vec3 p, Vec3 q, double step, double tolerance) {
    if (!single_ && !focus_.empty()) surface_ = focus_.front();
    double at_near = fix_side(p);
    const int steps = static_cast<int>(std::clamp(std::ceil(length(q - p) / step), 1.0, 64.0));
    Vec3 near = p;
    for (int i = 1; i <= steps; ++i) {
        const Vec3 far = p + (static_cast<double>(i) / steps) * (q - p);
        const double at_far = side_distance(far);
        if (at_far < 0) return crossing_between(near, far, at_near, at_far, tolerance);
        near = far;
        at_near = at_far;
    }
    return std::nullopt;
}

}  // namespace anatomesh
