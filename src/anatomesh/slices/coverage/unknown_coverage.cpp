#include "anatomesh/slices/coverage/unknown_coverage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomesh/slices/arrangement/parallel_slices.h"
#include "anatomesh/slices/arrangement/stack_and_crossing.h"
#include "anatomesh/slices/arrangement/sweep.h"
#include "anatomesh/slices/coverage/covering_slices.h"
#include "anatomesh/slices/coverage/undrawn_structures.h"

namespace anatomesh {

namespace {

constexpr double same_stack = 0.94;  // cosine of the angle between planes, as by hand: 20 degrees

struct SliceInOrder {
    double height = 0;
    std::uint32_t slice = 0;
    bool draws = false;  // the structure
};

// Slices of about one direction, in order along it where the structure is, and the heights of its own that
// were left out.
struct Stack {
    std::vector<SliceInOrder> slices;
    std::vector<double> left_out;
};

Stack in_order(const ContourSet& set, std::uint32_t structure, const std::vector<std::uint32_t>& slices,
               const std::vector<bool>& draws) {
    Vec3 middle;
    double points = 0;
    for (const std::uint32_t s : slices) {
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            if (contour.structure != structure) continue;
            for (const Vec3& p : set.points_of(contour)) middle += p;
            points += contour.point_count;
        }
    }
    middle = (1 / points) * middle;
    // The mean of their normals: along one of them places far off are uneven where slices lean as by hand.
    const Vec3 first = set.slices[slices.front()].plane.normal;
    Vec3 sum;
    for (const std::uint32_t s : slices) {
        const Vec3 normal = set.slices[s].plane.normal;
        sum += (dot(normal, first) < 0 ? -1.0 : 1.0) * normal;
    }
    const Vec3 way = normalized(sum);
    std::vector<SliceInOrder> ordered;
    for (const std::uint32_t s : slices) {
        const Plane& plane = set.slices[s].plane;
        ordered.push_back({-plane.signed_distance(middle) / dot(plane.normal, way), s, draws[s]});
    }
    std::sort(ordered.begin(), ordered.end(), [](const SliceInOrder& a, const SliceInOrder& b) {
        return a.height != b.height ? a.height < b.height : a.slice < b.slice;
    });
    return {std::move(ordered), heights_left_out(set, structure, middle, way)};
}

// The slices that a structure skips which is drawn on slices of its own.
void add_skipped(const Stack& stack, std::uint32_t structure, std::vector<std::vector<bool>>& unknown) {
    const std::vector<SliceInOrder>& ordered = stack.slices;
    std::vector<std::uint32_t> drawn;
    std::vector<double> heights;
    for (const SliceInOrder& one : ordered) heights.push_back(one.height);
    for (std::uint32_t n = 0; n < ordered.size(); ++n) {
        if (ordered[n].draws) drawn.push_back(n);
    }
    const std::vector<std::uint32_t> covering = covering_slices(drawn, heights, stack.left_out);
    for (std::uint32_t n = drawn.front(); n < drawn.back(); ++n) {
        if (!std::binary_search(covering.begin(), covering.end(), n))
            unknown[ordered[n].slice][structure] = true;
    }
}

// Structures drawn on every other slice of planes that nearly lie on each other.
void add_interleaved(const ContourSet& set, std::vector<std::vector<bool>>& unknown) {
    for (std::uint32_t structure = 0; structure < set.structures.size(); ++structure) {
        std::vector<bool> draws(set.slices.size(), false);
        for (const Contour& contour : set.contours) {
            if (contour.structure == structure) draws[contour.slice] = true;
        }
        std::vector<bool> seen(set.slices.size(), false);
        for (std::uint32_t first = 0; first < set.slices.size(); ++first) {
            if (!draws[first] || seen[first]) continue;
            std::vector<std::uint32_t> stack;
            for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
                if (set.slices[s].contour_count == 0 || seen[s] ||
                    std::abs(dot(set.slices[s].plane.normal, set.slices[first].plane.normal)) < same_stack)
                    continue;
                seen[s] = draws[s];
                stack.push_back(s);
            }
            add_skipped(in_order(set, structure, stack, draws), structure, unknown);
        }
    }
}

}  // namespace

UnknownCoverage UnknownCoverage::of(const ContourSet& set, RunContext& context) {
    UnknownCoverage made;
    if (set.structures.size() < 2 || is_parallel(set) || Sweep::of(set)) return made;
    std::vector<std::vector<bool>> unknown(set.slices.size(),
                                           std::vector<bool>(set.structures.size(), false));
    for (const UndrawnStructure& missing : find_undrawn_structures(set, context))
        unknown[missing.slice][missing.structure] = true;
    add_interleaved(set, unknown);
    if (const auto slices = stack_and_crossing(set)) {
        for (const std::uint32_t s : slices->crossing) {
            unknown[s].assign(set.structures.size(), true);
            for (const Contour& contour : set.contours_of(set.slices[s]))
                unknown[s][contour.structure] = false;
        }
    }
    const auto any = [](const std::vector<bool>& of_slice) {
        return std::find(of_slice.begin(), of_slice.end(), true) != of_slice.end();
    };
    if (std::any_of(unknown.begin(), unknown.end(), any)) made.unknown_ = std::move(unknown);
    return made;
}

}  // namespace anatomesh
