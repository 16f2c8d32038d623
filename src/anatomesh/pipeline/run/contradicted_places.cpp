#include "anatomesh/pipeline/run/contradicted_places.h"

#include <algorithm>
#include <cassert>

#include "anatomesh/measure/contradicted_segments.h"
#include "anatomesh/slices/arrangement/plane_patches.h"
#include "anatomesh/slices/lines/line_intervals.h"

namespace anatomesh {

namespace {

// The ends of both along the line: between every other two exactly one has the structure.
std::vector<double> ends_of_difference(const LineComparison& comparison) {
    std::vector<double> ends;
    for (const IntervalEndpoint& end : comparison.endpoints_a) ends.push_back(end.t);
    for (const IntervalEndpoint& end : comparison.endpoints_b) ends.push_back(end.t);
    std::sort(ends.begin(), ends.end());
    return ends;
}

}  // namespace

std::vector<ContradictedPlace> contradicted_places(const ContourSet& contours,
                                                   std::span<const double> weights, RunContext& context) {
    const std::size_t slices = contours.slices.size();
    assert(weights.size() == contours.structures.size() * slices);
    const std::vector<PlanePatch> patches = plane_patches(contours);
    std::vector<ContradictedPlace> places;
    for (const LineComparison& comparison :
         compare_planes(contours, patches, crossing_pairs(patches, 0), 0, context)) {
        const double* weight = &weights[comparison.structure * slices];
        if (weight[comparison.a] == 0 || weight[comparison.b] == 0) continue;
        const double low = std::max(comparison.seen_by_a[0], comparison.seen_by_b[0]),
                     high = std::min(comparison.seen_by_a[1], comparison.seen_by_b[1]);
        const std::vector<double> ends = ends_of_difference(comparison);
        for (std::size_t n = 0; n + 1 < ends.size(); n += 2) {
            const double from = std::max(ends[n], low), to = std::min(ends[n + 1], high);
            if (to - from > contradiction_mm)
                places.push_back({comparison.structure, comparison.line.at(from), comparison.line.at(to)});
        }
    }
    return places;
}

}  // namespace anatomesh
