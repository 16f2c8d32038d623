#include "anatomesh/slices/coverage/slice_coverage.h"

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "anatomesh/slices/coverage/covering_slices.h"
#include "anatomesh/slices/coverage/few_slices.h"
#include "anatomesh/slices/coverage/undrawn_structures.h"

namespace anatomesh {

SliceCoverage::SliceCoverage(const ContourSet& set)
    : structures_(set.structures.size()), of_(set.slices.size() * structures_, Coverage::absent) {
    for (const Contour& contour : set.contours)
        of_[contour.slice * structures_ + contour.structure] = Coverage::drawn;
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        for (std::uint32_t s = 0; s < structures_ && !set.slices[k].interpolated.empty(); ++s) {
            Coverage& coverage = of_[k * structures_ + s];
            if (coverage == Coverage::drawn && is_interpolated(set, k, s)) coverage = Coverage::interpolated;
        }
    }
}

namespace {

// Planes within 20 degrees, of which this is the cosine, are slices side by side, as a hand holds a probe.
// [1, cosine; 0 to 1; M 2026-11 organ on nine of 27 freehand planes]
constexpr double same_stack = 0.94;

// Slices in the order in which they lie.
struct OrderedSlices {
    std::vector<std::uint32_t> slices;
    std::vector<double> heights;  // of these, along `direction` from `middle`; empty: not known
    Vec3 middle, direction;
};

// All slices of a set; they have heights where they are a stack or a sweep.
OrderedSlices in_order(const ContourSet& set, const SliceArrangement& arrangement) {
    OrderedSlices result;
    result.slices.resize(set.slices.size());
    std::iota(result.slices.begin(), result.slices.end(), 0u);
    if (set.slices.empty() || !arrangement.is_stack()) return result;
    const Box3 box = set.box();
    result.middle = 0.5 * (box.low + box.high);
    result.direction = set.slices.front().plane.normal;
    std::vector<double> at;
    for (const Slice& slice : set.slices)
        at.push_back(-slice.plane.signed_distance(result.middle) / dot(slice.plane.normal, result.direction));
    std::stable_sort(result.slices.begin(), result.slices.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return at[a] < at[b]; });
    for (const std::uint32_t s : result.slices) result.heights.push_back(at[s]);
    return result;
}

// Some slices of about one direction, at their heights where the structure is.
OrderedSlices in_order_at(const ContourSet& set, std::uint32_t structure,
                          const std::vector<std::uint32_t>& slices) {
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
    // The direction is the mean of the normals: along one of them, places far off are uneven where slices
    // lean as by hand.
    const Vec3 first = set.slices[slices.front()].plane.normal;
    Vec3 sum;
    for (const std::uint32_t s : slices) {
        const Vec3 normal = set.slices[s].plane.normal;
        sum += (dot(normal, first) < 0 ? -1.0 : 1.0) * normal;
    }
    const Vec3 direction = normalized(sum);
    std::vector<std::pair<double, std::uint32_t>> places;
    for (const std::uint32_t s : slices) {
        const Plane& plane = set.slices[s].plane;
        places.emplace_back(-plane.signed_distance(middle) / dot(plane.normal, direction), s);
    }
    std::sort(places.begin(), places.end());
    OrderedSlices result{{}, {}, middle, direction};
    for (const auto& [height, slice] : places) {
        result.slices.push_back(slice);
        result.heights.push_back(height);
    }
    return result;
}

// A structure among ordered slices: the places of those that draw it and of those that cover it, rising.
struct CoveringPlaces {
    std::vector<std::uint32_t> drawn, covering;
    bool has_skipped() const { return covering.size() < drawn.back() - drawn.front() + 1u; }
};

// Nothing where the slices do not draw the structure.
std::optional<CoveringPlaces> covering_places(const ContourSet& set, const SliceCoverage& coverage,
                                              std::uint32_t structure, const OrderedSlices& order) {
    CoveringPlaces places;
    for (std::uint32_t n = 0; n < order.slices.size(); ++n) {
        if (coverage.is_drawn(order.slices[n], structure)) places.drawn.push_back(n);
    }
    if (places.drawn.empty()) return std::nullopt;
    std::vector<double> left_out;
    if (!order.heights.empty()) left_out = heights_left_out(set, structure, order.middle, order.direction);
    places.covering = covering_slices(places.drawn, order.heights, left_out);
    return places;
}

// Marks, for all structures but those decided already, the slices that one skips in the order of the set.
void mark_skipped(const ContourSet& set, const SliceArrangement& arrangement,
                  const std::vector<std::uint8_t>& decided, Coverage as, SliceCoverage& coverage) {
    const OrderedSlices order = in_order(set, arrangement);
    for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
        if (decided[s]) continue;
        const std::optional<CoveringPlaces> places = covering_places(set, coverage, s, order);
        if (!places || !places->has_skipped()) continue;
        for (std::uint32_t n = 0; n < order.slices.size(); ++n) {
            if (!std::binary_search(places->covering.begin(), places->covering.end(), n))
                coverage.set_absence(order.slices[n], s, as);
        }
    }
}

// Marks what the levels of nested structures say of the slices of the whole. Returns, by structure, whether it
// is decided: whether a level has it.
std::vector<std::uint8_t> mark_by_level(const ContourSet& set, Coverage as, SliceCoverage& coverage) {
    std::vector<std::uint8_t> decided(set.structures.size(), 0);
    if (!set.overlapping) return decided;
    const OverlappingContours& all = *set.overlapping;
    for (std::size_t n = 0; n < all.levels.size(); ++n) {
        const ContourSet& level = all.levels[n];
        SliceCoverage of_level(level);
        // A level is another set than the whole: some of its slices, which may lie otherwise than all do.
        if (!says_all(level)) {
            const std::vector<std::uint8_t> none(level.structures.size(), 0);
            mark_skipped(level, arrangement_of(level), none, Coverage::unknown, of_level);
        }
        for (std::uint32_t s = 0; s < level.structures.size(); ++s) {
            const auto same =
                std::find_if(set.structures.begin(), set.structures.end(),
                             [&](const auto& one) { return one.number == level.structures[s].number; });
            const auto structure = static_cast<std::uint32_t>(same - set.structures.begin());
            if (same == set.structures.end() || std::exchange(decided[structure], std::uint8_t{1})) continue;
            std::vector<std::uint8_t> says(set.slices.size(), 0);
            for (std::uint32_t k = 0; k < level.slices.size(); ++k)
                says[all.slices[n][k]] = !of_level.is_unknown(k, s);
            for (std::uint32_t k = 0; k < says.size(); ++k) {
                if (!says[k]) coverage.set_absence(k, structure, as);
            }
        }
    }
    return decided;
}

// Marks structures drawn on every other slice of planes that nearly lie on each other.
void mark_interleaved(const ContourSet& set, SliceCoverage& coverage) {
    for (std::uint32_t structure = 0; structure < set.structures.size(); ++structure) {
        std::vector<std::uint8_t> seen(set.slices.size(), 0);
        for (std::uint32_t first = 0; first < set.slices.size(); ++first) {
            if (!coverage.is_drawn(first, structure) || seen[first]) continue;
            std::vector<std::uint32_t> stack;
            for (std::uint32_t s = 0; s < set.slices.size(); ++s) {
                if (set.slices[s].contour_count == 0 || seen[s] ||
                    std::abs(dot(set.slices[s].plane.normal, set.slices[first].plane.normal)) < same_stack)
                    continue;
                seen[s] = coverage.is_drawn(s, structure);
                stack.push_back(s);
            }
            const OrderedSlices order = in_order_at(set, structure, stack);
            const CoveringPlaces places = *covering_places(set, coverage, structure, order);
            for (std::uint32_t n = places.drawn.front(); n < places.drawn.back(); ++n) {
                if (!std::binary_search(places.covering.begin(), places.covering.end(), n))
                    coverage.set_absence(order.slices[n], structure, Coverage::unknown);
            }
        }
    }
}

// Marks what slices that cross leave unknown.
void mark_where_slices_cross(const ContourSet& set, const SliceArrangement& arrangement,
                             SliceCoverage& coverage, RunContext& context) {
    for (const UndrawnStructure& missing : find_undrawn_structures(set, context))
        coverage.set_absence(missing.slice, missing.structure, Coverage::unknown);
    mark_interleaved(set, coverage);
    if (!arrangement.parts) return;
    for (const std::uint32_t k : arrangement.parts->crossing) {
        for (std::uint32_t s = 0; s < set.structures.size(); ++s)
            coverage.set_absence(k, s, Coverage::unknown);
    }
}

// A slice says what its own path draws, and there by the rules of a stack; of all other structures it says nothing.
void mark_along_paths(const ContourSet& set, const std::vector<SlicePath>& paths, SliceCoverage& coverage) {
    std::vector<std::uint8_t> says(set.slices.size() * set.structures.size(), 0);
    for (const SlicePath& path : paths) {
        OrderedSlices order;
        for (std::size_t n = 0; n < path.slices().size(); ++n) {
            order.slices.push_back(path.slices()[n].slice);
            order.heights.push_back(path.height(n));
        }
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            CoveringPlaces places;
            for (std::uint32_t n = 0; n < order.slices.size(); ++n) {
                const std::vector<std::uint32_t>& contours = path.slices()[n].contours;
                if (std::any_of(contours.begin(), contours.end(),
                                [&](std::uint32_t c) { return set.contours[c].structure == s; }))
                    places.drawn.push_back(n);
            }
            if (places.drawn.empty()) continue;
            places.covering = covering_slices(places.drawn, order.heights);
            const bool all = !places.has_skipped();
            for (std::uint32_t n = 0; n < order.slices.size(); ++n) {
                says[order.slices[n] * set.structures.size() + s] |=
                    all || std::binary_search(places.covering.begin(), places.covering.end(), n);
            }
        }
    }
    for (std::uint32_t k = 0; k < set.slices.size(); ++k) {
        for (std::uint32_t s = 0; s < set.structures.size(); ++s) {
            if (!says[k * set.structures.size() + s]) coverage.set_absence(k, s, Coverage::unknown);
        }
    }
}

// Slices as good as on the plane of one that draws a structure on few slices say nothing of it.
void mark_beside_few(const ContourSet& set, SliceCoverage& coverage) {
    const std::vector<SliceInterval> intervals = parallel_intervals(set, set.slices.front().plane);
    for (const FewSlices& few : structures_on_few_slices(set, intervals, 0))
        for (const std::uint32_t drawn : few.slices)
            for (std::uint32_t k = 0; k < set.slices.size() && few.mm > 0; ++k) {
                const double away =
                    std::abs(set.slices[drawn].plane.signed_distance(set.slices[k].plane.origin));
                if (away <= same_plane_share * few.mm)
                    coverage.set_absence(k, few.structure, Coverage::unknown);
            }
}

}  // namespace

SliceCoverage coverage_of(const ContourSet& set, const SliceArrangement& arrangement, RunContext& context) {
    SliceCoverage coverage(set);
    if (arrangement.is_along_paths()) {
        mark_along_paths(set, arrangement.paths, coverage);
        return coverage;
    }
    const Coverage skipped = arrangement.is_stack() ? Coverage::unknown : Coverage::doubtful;
    const std::vector<std::uint8_t> decided = mark_by_level(set, skipped, coverage);
    if (!says_all(set)) mark_skipped(set, arrangement, decided, skipped, coverage);
    if (arrangement.is_parallel()) mark_beside_few(set, coverage);
    if (!arrangement.is_stack() && set.structures.size() > 1)
        mark_where_slices_cross(set, arrangement, coverage, context);
    return coverage;
}

SliceFacts slice_facts_of(const ContourSet& set, double max_gap, RunContext& context) {
    SliceFacts facts{arrangement_of(set, max_gap), {}};
    facts.coverage = coverage_of(set, facts.arrangement, context);
    return facts;
}

}  // namespace anatomesh
