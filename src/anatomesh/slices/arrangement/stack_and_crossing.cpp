#include "anatomesh/slices/arrangement/stack_and_crossing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "anatomesh/contour/model/chosen_slices.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/arrangement/sweep.h"

namespace anatomesh {

namespace {

// Two slices nearly cross that are somewhere nearer than this share of their mean distance, and then no chart
// holds both. [1; 0 to 1; M 2026-11 cups, hollow cylinders and balls with crossing planes]
constexpr double least_gap_share = 0.2;
// Fewer slices are no stack: their local spacing is not known.
// [slices; >= 2; M 2026-11 cups, hollow cylinders and balls with crossing planes]
constexpr std::size_t least_stack = 4;
// A stack has at least so many slices for each crossing plane, so that the crossing ones correct it and do
// not make it. [1; >= 1; M 2026-11 cups, hollow cylinders and balls with crossing planes]
constexpr std::size_t stack_to_crossing = 3;

// Whether the boxes of two slices' contours cross, or come much nearer at one place than at others.
bool nearly_cross(const PlanePatch& one, const PlanePatch& other) {
    if (one.box.empty() || other.box.empty()) return false;
    for (const auto& [plane, corners] :
         {std::pair{one.plane, other.corners()}, std::pair{other.plane, one.corners()}}) {
        double sum = 0, least = HUGE_VAL, most = -HUGE_VAL;
        for (const Vec3 p : corners) {
            const double height = plane.signed_distance(p);
            sum += height / 4;
            least = std::min(least, height);
            most = std::max(most, height);
        }
        if (std::min(std::abs(least), std::abs(most)) < least_gap_share * std::abs(sum) ||
            (least < 0) != (most < 0))
            return true;
    }
    return false;
}

bool is_stack(const ContourSet& set) {
    return is_parallel(set) || Sweep::of(set);
}

// Whether every structure of the set is drawn in two slices of the part.
bool draws_all(const ContourSet& part, const ContourSet& set) {
    std::vector<std::uint32_t> drawn(set.structures.size(), 0);
    std::vector<std::uint32_t> last(set.structures.size(), static_cast<std::uint32_t>(-1));
    for (const Contour& contour : part.contours) {
        drawn[contour.structure] += last[contour.structure] != contour.slice;
        last[contour.structure] = contour.slice;
    }
    return std::all_of(set.contours.begin(), set.contours.end(),
                       [&](const Contour& contour) { return drawn[contour.structure] > 1; });
}

}  // namespace

std::optional<StackAndCrossing> stack_and_crossing(const ContourSet& set) {
    if (set.exclusive && set.structures.size() > 1) return std::nullopt;
    const std::vector<PlanePatch> patches = plane_patches(set);
    const std::size_t count = patches.size();
    std::vector<std::vector<std::uint32_t>> crossed(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = 0; j < i; ++j) {
            if (!nearly_cross(patches[i], patches[j])) continue;
            crossed[i].push_back(j);
            crossed[j].push_back(i);
        }
    }
    // Of two that cross each other alone the one that leans more against all others.
    std::vector<double> lean(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j)
            lean[i] += 1 - std::abs(dot(patches[i].plane.normal, patches[j].plane.normal));
    }
    std::vector<std::uint8_t> is_crossing(count, 0);
    StackAndCrossing made;
    while (stack_to_crossing * made.crossing.size() <= count) {
        std::uint32_t worst = 0;
        for (std::uint32_t i = 1; i < count; ++i) {
            if (std::pair(crossed[i].size(), lean[i]) > std::pair(crossed[worst].size(), lean[worst]))
                worst = i;
        }
        if (crossed[worst].empty()) break;
        for (const std::uint32_t j : std::exchange(crossed[worst], {})) std::erase(crossed[j], worst);
        is_crossing[worst] = 1;
        made.crossing.push_back(worst);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!is_crossing[i]) made.stack.push_back(i);
    }
    if (made.crossing.empty() || made.stack.size() < least_stack ||
        made.stack.size() < stack_to_crossing * made.crossing.size())
        return std::nullopt;
    std::sort(made.crossing.begin(), made.crossing.end());
    // Planes closer than the vertices along them have no need of it.
    if (mean_vertex_spacing(set) > dense_spacing * plane_spacings(set, patches).median) return std::nullopt;
    const ContourSet stack = chosen_slices(set, made.stack);
    if (!draws_all(stack, set) || !is_stack(stack)) return std::nullopt;
    return made;
}

}  // namespace anatomesh
