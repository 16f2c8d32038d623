#include "anatomesh/slices/coverage/undrawn_structures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/geom/numbers.h"
#include "anatomesh/slices/coverage/slice_coverage.h"
#include "anatomesh/slices/lines/arc.h"

namespace anatomesh {

namespace {

// On which side of the slice those of its own direction draw the structure, -1 or 1; 0: on both or not at
// all.
int side_of_structure(const ContourSet& set, const SliceCoverage& drawn, std::uint32_t slice,
                      std::uint32_t structure) {
    const Plane& plane = set.slices[slice].plane;
    bool above = false, below = false;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        if (!drawn.is_drawn(s, structure) ||
            std::abs(dot(set.slices[s].plane.normal, plane.normal)) < cos_of_about_30_degrees)
            continue;
        for (const Contour& contour : set.contours_of(set.slices[s])) {
            if (contour.structure != structure) continue;
            for (const Vec3& p : set.points_of(contour)) {
                const double height = plane.signed_distance(p);
                above |= height > line_in_plane_mm;
                below |= height < -line_in_plane_mm;
            }
        }
    }
    return above == below ? 0 : above ? 1 : -1;
}

// How many slices of other directions draw the structure.
std::uint32_t drawn_across(const ContourSet& set, const SliceCoverage& drawn, std::uint32_t slice,
                           std::uint32_t structure) {
    std::uint32_t count = 0;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
        const double cosine = std::abs(dot(set.slices[s].plane.normal, set.slices[slice].plane.normal));
        count += drawn.is_drawn(s, structure) && cosine < cos_of_about_30_degrees;
    }
    return count;
}

// How far the structure goes beyond the line where one slice alone has it, on the side where that is less;
// infinite where no part of a contour keeps to one side.
double depth(const ContourSet& set, const LineComparison& c, bool of_a) {
    const std::vector<IntervalEndpoint>& ends = of_a ? c.endpoints_a : c.endpoints_b;
    const std::uint32_t own = of_a ? c.a : c.b, other = of_a ? c.b : c.a;
    double most = 0;
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
        const Arc arc =
            arc_between(set, ends[i], ends[i + 1], set.slices[own].plane, set.slices[other].plane);
        most = std::max(most, arc.points.empty() ? HUGE_VAL : arc.height_mm);
    }
    return most;
}

struct Shown {
    std::uint32_t by = 0, slices = 0;
    double length_mm = 0, depth_mm = 0;  // the most on any line
    int side = 0;                        // where it is beyond an end of the structure: that of the structure
    bool is_undrawn = false;
};

// Whether slice `far` lies beyond slice `near`, seen from a structure on the given side of both.
bool lies_beyond(const ContourSet& set, std::uint32_t far, std::uint32_t near, int side) {
    const Plane &plane = set.slices[near].plane, &other = set.slices[far].plane;
    if (std::abs(dot(plane.normal, other.normal)) < cos_of_about_30_degrees) return false;
    Vec3 middle;
    const Slice& slice = set.slices[far];
    double count = 0;
    for (const Contour& contour : set.contours_of(slice)) {
        for (const Vec3& p : set.points_of(contour)) {
            middle += p;
            ++count;
        }
    }
    return count > 0 && side * plane.signed_distance((1 / count) * middle) < -line_in_plane_mm;
}

}  // namespace

std::vector<UndrawnStructure> find_undrawn_structures(const ContourSet& set,
                                                      std::span<const LineComparison> comparisons,
                                                      double spacing) {
    const SliceCoverage drawn(set);
    std::map<std::pair<std::uint32_t, std::uint32_t>, Shown> shown;  // by slice and structure
    for (const LineComparison& c : comparisons) {
        for (const bool of_a : {true, false}) {
            const std::uint32_t own = of_a ? c.a : c.b, other = of_a ? c.b : c.a;
            if ((of_a ? c.endpoints_a : c.endpoints_b).empty() || drawn.is_drawn(other, c.structure))
                continue;
            Shown& most = shown[{other, c.structure}];
            ++most.slices;
            if (c.difference_mm > most.length_mm) most.by = own;
            most.length_mm = std::max(most.length_mm, c.difference_mm);
            most.depth_mm = std::max(most.depth_mm, depth(set, c, of_a));
        }
    }
    for (auto& [key, most] : shown) {
        const auto [slice, structure] = key;
        const bool few = 2 * most.slices <= drawn_across(set, drawn, slice, structure);
        most.side = side_of_structure(set, drawn, slice, structure);
        most.is_undrawn = most.side == 0 || (!few && most.depth_mm > spacing);
    }
    // Where the structure goes on through one slice, those beyond do not end it.
    std::vector<UndrawnStructure> undrawn;
    for (const auto& [key, most] : shown) {
        const auto [slice, structure] = key;
        const bool is_led_beyond = std::any_of(
            shown.begin(), shown.end(), [&, slice = slice, structure = structure](const auto& near) {
                return near.second.is_undrawn && near.second.side != 0 && near.first.second == structure &&
                       near.first.first != slice &&
                       lies_beyond(set, slice, near.first.first, near.second.side);
            });
        if (most.is_undrawn || is_led_beyond) undrawn.push_back({slice, structure, most.by, most.length_mm});
    }
    return undrawn;
}

std::vector<UndrawnStructure> find_undrawn_structures(const ContourSet& set, RunContext& context) {
    const SliceCoverage drawn(set);
    std::vector<std::uint32_t> anywhere;  // structures that some slice draws
    for (const Contour& contour : set.contours) anywhere.push_back(contour.structure);
    sort_distinct(anywhere);
    const auto leaves_out = [&](std::uint32_t slice) {
        return set.slices[slice].contour_count > 0 &&
               !std::all_of(anywhere.begin(), anywhere.end(),
                            [&](std::uint32_t s) { return drawn.is_drawn(slice, s); });
    };
    const std::vector<PlanePatch> patches = plane_patches(set);
    bool any = false;
    for (std::uint32_t s = 0; s < set.slices.size(); ++s) any |= leaves_out(s);
    if (!any) return {};
    const double spacing = plane_spacings(set, patches).median;
    auto pairs = crossing_pairs(patches, spacing);
    std::erase_if(pairs,
                  [&](const auto& pair) { return !leaves_out(pair.first) && !leaves_out(pair.second); });
    return find_undrawn_structures(set, compare_planes(set, patches, pairs, spacing, context), spacing);
}

bool is_undrawn(std::span<const UndrawnStructure> undrawn, std::uint32_t slice, std::uint32_t structure) {
    const auto at = std::lower_bound(undrawn.begin(), undrawn.end(), std::pair(slice, structure),
                                     [](const UndrawnStructure& missing, const auto& key) {
                                         return std::pair(missing.slice, missing.structure) < key;
                                     });
    return at != undrawn.end() && at->slice == slice && at->structure == structure;
}

}  // namespace anatomesh
