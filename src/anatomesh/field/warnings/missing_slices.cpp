#include "anatomesh/field/warnings/missing_slices.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "anatomesh/contour/planes/common_normal.h"
#include "anatomesh/geom/numbers.h"

namespace anatomesh {

namespace {

// Among fewer slices no gap is usual. [slices; >= 3; M 2026-11, set not recorded]
constexpr std::size_t fewest_slices = 5;
// Planes that run no further beside the axis of a turn are slices about it, and their gaps are angles.
// [diagonals of the box; 0 to 1; M 2026-11, set not recorded]
constexpr double most_beside = 0.05;
// A gap wider than so many gaps that three in four do not exceed lacks slices. [usual gaps; > 1; C W-FLD-001]
constexpr double widest = 2.5;

// The widest of some gaps, and where it is, if it is far wider than the others.
struct Widest {
    double gap = 0;
    std::size_t after = 0;
};
Widest far_wider(std::vector<double> gaps) {
    const auto at = std::max_element(gaps.begin(), gaps.end());
    const Widest widest_one{*at, static_cast<std::size_t>(at - gaps.begin())};
    // Slices of two passes come in pairs.
    const std::size_t usual = 3 * (gaps.size() - 1) / 4;
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(usual), gaps.end());
    return widest_one.gap > widest * gaps[usual] ? widest_one : Widest{};
}

// A gap after the slice at that place of a row of them, the last of which the first follows.
void warn(const ContourSet& set, const std::vector<std::pair<double, std::uint32_t>>& row,
          const Widest& found, const char* what, const char* unit, double scale, RunContext& context) {
    const std::uint32_t from = row[found.after].second, to = row[(found.after + 1) % row.size()].second;
    char value[64];
    std::snprintf(value, sizeof value, "%.3g %s, between it and slice ", scale * found.gap, unit);
    context.warn({"W-FLD-001",
                  what,
                  {set.source, set.slices[from].name, "", "", value + set.slices[to].name},
                  "the structure continues there as far as slices on both sides show it, and ends elsewhere; "
                  "draw slices there"});
}

bool warn_about_row(const ContourSet& set, RunContext& context) {
    const std::optional<Vec3> mean = common_normal(set);
    if (!mean) return false;
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    std::vector<std::pair<double, std::uint32_t>> places;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const Plane& plane = set.slices[s].plane;
        places.emplace_back(-plane.signed_distance(middle) / dot(plane.normal, *mean), s);
    }
    std::sort(places.begin(), places.end());
    std::vector<double> gaps;
    for (std::size_t k = 1; k < places.size(); ++k) gaps.push_back(places[k].first - places[k - 1].first);
    const Widest found = far_wider(gaps);
    if (found.gap > 0)
        warn(set, places, found, "slices are missing between slices that are not parallel", "mm", 1, context);
    return found.gap > 0;
}

// Of planes that all run through what is drawn near one line.
void warn_about_turn(const ContourSet& set, const Axis& axis, RunContext& context) {
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high), way = middle - axis.origin;
    const Vec3 nearest = axis.origin + dot(way, axis.direction) * axis.direction;
    if (!box.contains(nearest)) return;
    const Plane across = make_plane(axis.origin, axis.direction);
    std::vector<std::pair<double, std::uint32_t>> angles;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const Plane& plane = set.slices[s].plane;
        if (std::abs(plane.signed_distance(nearest)) > most_beside * box.diagonal()) return;
        const double angle = std::atan2(dot(plane.normal, across.v), dot(plane.normal, across.u));
        angles.emplace_back(angle < 0 ? angle + std::numbers::pi : angle, s);
    }
    std::sort(angles.begin(), angles.end());
    std::vector<double> gaps;
    for (std::size_t k = 1; k < angles.size(); ++k) gaps.push_back(angles[k].first - angles[k - 1].first);
    gaps.push_back(angles.front().first + std::numbers::pi - angles.back().first);
    if (const Widest found = far_wider(gaps); found.gap > 0)
        warn(set, angles, found, "slices about an axis leave a part of the turn out", "degrees",
             degrees_per_radian, context);
}

}  // namespace

void warn_about_missing_slices(const ContourSet& set, const Axis& axis, RunContext& context) {
    if (set.slices.size() < fewest_slices) return;
    if (!warn_about_row(set, context)) warn_about_turn(set, axis, context);
}

}  // namespace anatomesh
