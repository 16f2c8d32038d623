#include "anatomesh/field/missing_slices.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace anatomesh {

namespace {

constexpr std::size_t fewest_slices = 5;
constexpr double least_cosine = 0.866;  // of the angle between a plane's normal and the mean
constexpr double widest = 2.5;          // times the gap that three in four do not exceed

// The mean of the normals, all on one side of it; nothing where one leans too far against it.
bool mean_normal(const ContourSet& set, Vec3& mean) {
    const Vec3 first = set.slices.front().plane.normal;
    Vec3 sum{};
    for (const Slice& slice : set.slices) {
        const Vec3 n = slice.plane.normal;
        sum += dot(n, first) < 0 ? -1.0 * n : n;
    }
    if (!(squared_length(sum) > 0)) return false;
    mean = normalized(sum);
    return std::all_of(set.slices.begin(), set.slices.end(), [&](const Slice& slice) {
        return std::abs(dot(slice.plane.normal, mean)) >= least_cosine;
    });
}

}  // namespace

void warn_about_missing_slices(const ContourSet& set, RunContext& context) {
    Vec3 mean;
    if (set.slices.size() < fewest_slices || !mean_normal(set, mean)) return;
    const Box3 box = set.box();
    const Vec3 middle = 0.5 * (box.low + box.high);
    std::vector<std::pair<double, std::uint32_t>> places;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const Plane& plane = set.slices[s].plane;
        places.emplace_back(-plane.signed_distance(middle) / dot(plane.normal, mean), s);
    }
    std::sort(places.begin(), places.end());
    std::vector<double> gaps;
    for (std::size_t k = 1; k < places.size(); ++k) gaps.push_back(places[k].first - places[k - 1].first);
    const auto at = std::max_element(gaps.begin(), gaps.end());
    const auto below = static_cast<std::size_t>(at - gaps.begin());
    const double gap = *at;
    // Slices of two passes come in pairs.
    const std::size_t usual = 3 * gaps.size() / 4;
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(usual), gaps.end());
    if (!(gap > widest * gaps[usual])) return;
    char value[64];
    std::snprintf(value, sizeof value, "%.3g mm, between it and slice ", gap);
    context.warn({"W-FLD-001",
                  "slices are missing between slices that are not parallel",
                  {set.source, set.slices[places[below].second].name, "", "",
                   value + set.slices[places[below + 1].second].name},
                  "what is drawn goes on there as far as slices on both sides tell, and ends elsewhere: draw "
                  "slices there"});
}

}  // namespace anatomesh
