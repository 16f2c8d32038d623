#include "anatomesh/measure/topology/stacks_of_slices.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "anatomesh/contour/model/chosen_slices.h"

namespace anatomesh {

namespace {

// A family of slices has no fewer. [slices; >= 2; M 2026-11 two things 0.6 mm apart in three stacks]
constexpr std::size_t least_slices = 4;
const double most_sine = std::sin(std::numbers::pi / 180);

std::optional<StackOfSlices> stack_of(const ContourSet& contours, const std::vector<std::uint32_t>& chosen) {
    // Chosen slices are another set, and parallel ones need a chart here too: the sweep is asked for by itself.
    const ContourSet some = chosen_slices(contours, chosen);
    std::optional<Sweep> sweep = Sweep::of(some);
    if (!sweep) return std::nullopt;
    const std::vector<std::uint32_t> order = sweep->order();
    StackOfSlices stack{std::move(*sweep), {}, {}, true};
    stack.charted = chosen_slices(stack.sweep.to_chart(some), order);
    for (const std::uint32_t s : order) stack.slices.push_back(chosen[s]);
    return stack;
}

// Slices of about one direction each, in the order of their first ones.
std::vector<std::vector<std::uint32_t>> families(const ContourSet& contours) {
    std::vector<std::vector<std::uint32_t>> found;
    std::vector<std::uint8_t> taken(contours.slices.size(), 0);
    for (std::uint32_t s = 0; s < contours.slices.size(); ++s) {
        if (taken[s]) continue;
        std::vector<std::uint32_t> family;
        for (std::uint32_t t = s; t < contours.slices.size(); ++t) {
            const Vec3 across = cross(contours.slices[s].plane.normal, contours.slices[t].plane.normal);
            if (taken[t] || length(across) > most_sine) continue;
            taken[t] = 1;
            family.push_back(t);
        }
        if (family.size() >= least_slices) found.push_back(std::move(family));
    }
    return found;
}

// Of a contour through gaps: where each of its points lies, 2k + 1 on slice k and 2k below it.
void mark_turns(const std::vector<std::uint32_t>& positions, std::size_t slices,
                std::vector<std::uint8_t>& turns) {
    const std::size_t count = positions.size();
    const auto first_change = [&]() -> std::size_t {
        for (std::size_t n = 0; n < count; ++n) {
            if (positions[n] != positions[(n + count - 1) % count]) return n;
        }
        return count;
    }();
    const auto mark = [&](std::uint32_t position) {
        if (position % 2 == 0 && position > 0 && position < 2 * slices) turns[position / 2 - 1] = 1;
    };
    if (first_change == count) return mark(positions.front());
    for (std::size_t n = 0; n < count;) {
        const std::uint32_t before = positions[(first_change + n + count - 1) % count],
                            here = positions[(first_change + n) % count];
        while (n < count && positions[(first_change + n) % count] == here) ++n;
        const std::uint32_t after = positions[(first_change + n) % count];
        if ((before < here) == (after < here)) mark(here);
    }
}

}  // namespace

std::vector<StackOfSlices> stacks_of_slices(const ContourSet& contours, const SliceArrangement& arrangement) {
    std::vector<StackOfSlices> stacks;
    // Parallel slices of two legs of an arch go on into each other far from here.
    if (arrangement.is_along_paths()) return stacks;
    const auto add = [&](const std::vector<std::uint32_t>& chosen) {
        if (std::optional<StackOfSlices> stack = stack_of(contours, chosen))
            stacks.push_back(std::move(*stack));
    };
    std::vector<std::uint32_t> all(contours.slices.size());
    std::iota(all.begin(), all.end(), 0u);
    add(all);
    if (!stacks.empty()) return stacks;
    if (arrangement.parts) {
        add(arrangement.parts->stack);
        return stacks;
    }
    for (const std::vector<std::uint32_t>& family : families(contours)) add(family);
    for (StackOfSlices& stack : stacks) stack.leads = false;
    return stacks;
}

std::vector<std::vector<std::uint8_t>> turns_in_gaps(const ContourSet& contours, const StackOfSlices& stack,
                                                     double tolerance_mm) {
    const std::vector<Slice>& slices = stack.charted.slices;
    std::vector<double> levels;
    for (const Slice& slice : slices) levels.push_back(dot(slice.plane.origin, slices.front().plane.normal));
    const auto position_of = [&](Vec3 p) {
        const double height = dot(stack.sweep.to_chart(p), slices.front().plane.normal);
        const auto next = std::lower_bound(levels.begin(), levels.end(), height - tolerance_mm);
        const auto k = static_cast<std::uint32_t>(next - levels.begin());
        return 2 * k + (next != levels.end() && *next <= height + tolerance_mm);
    };
    std::vector<std::uint8_t> in_stack(contours.slices.size(), 0);
    for (const std::uint32_t s : stack.slices) in_stack[s] = 1;
    std::vector<std::vector<std::uint8_t>> turns(contours.structures.size(),
                                                 std::vector<std::uint8_t>(slices.size() - 1, 0));
    std::vector<std::uint32_t> positions;
    for (const Contour& contour : contours.contours) {
        if (in_stack[contour.slice]) continue;
        positions.clear();
        for (const Vec3& p : contours.points_of(contour)) positions.push_back(position_of(p));
        mark_turns(positions, slices.size(), turns[contour.structure]);
    }
    return turns;
}

}  // namespace anatomesh
