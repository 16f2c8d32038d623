#include "anatomesh/contour/clean/complete_slices.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/clean/reading_log.h"

namespace anatomesh {

namespace {

// Complete slices further apart than so many of them are thick lack some between. [slices; >= 2; C W-FLD-014]
constexpr double widest_apart = 2.04;

std::vector<double> heights_of(const ContourSet& set) {
    std::vector<double> heights;
    for (const Slice& slice : set.slices)
        heights.push_back(dot(slice.plane.origin, set.slices.front().plane.normal));
    return heights;
}

// The slices between the first and the last one of a structure that do not have it.
void warn_of_absence(const ContourSet& set, std::uint32_t structure, const std::vector<std::uint32_t>& drawn,
                     const std::vector<double>& heights, RunContext& context) {
    std::uint32_t absent = 0, first = 0;
    double widest = 0;
    for (std::size_t n = 1; n < drawn.size(); ++n) {
        const std::uint32_t between = drawn[n] - drawn[n - 1] - 1;
        if (between == 0) continue;
        if (absent == 0) first = drawn[n - 1] + 1;
        absent += between;
        widest = std::max(widest, std::abs(heights[drawn[n]] - heights[drawn[n - 1]]));
    }
    if (absent == 0) return;
    context.warn(
        {"W-FLD-003",
         "the structure is not drawn on every slice between its first and its last one",
         {set.source, set.slices[first].name, structure_text(set.structures[structure]), "",
          std::to_string(absent) + " slices without it, gaps of up to " + brief(widest) + " mm"},
         "these slices were read as empty, because the file says that its slices are complete; leave "
         "out undrawn slices with --without"});
}

void warn_of_distance(const ContourSet& set, const std::vector<double>& heights, RunContext& context) {
    if (!(set.slice_thickness_mm > 0)) return;
    double widest = 0;
    std::size_t at = 0, wide = 0;
    for (std::size_t k = 1; k < heights.size(); ++k) {
        const double gap = std::abs(heights[k] - heights[k - 1]);
        wide += gap > widest_apart * set.slice_thickness_mm;
        if (gap <= widest) continue;
        widest = gap;
        at = k;
    }
    if (wide == 0) return;
    context.warn(
        {"W-FLD-014",
         "slices are missing: those that the file calls complete lie further apart than they are thick",
         {set.source, set.slices[at - 1].name, "", "",
          std::to_string(wide) + " gaps of up to " + brief(widest) + " mm between slices of " +
              brief(set.slice_thickness_mm) + " mm"},
         "what lies between was joined as between any slices, and is a guess; draw the slices between, "
         "or empty ones where nothing is"});
}

}  // namespace

void warn_about_complete_slices(const ContourSet& set, RunContext& context) {
    if (!set.complete || set.slices.size() < 2 || !all_parallel(set, parallel_tolerance_mm)) return;
    const std::vector<double> heights = heights_of(set);
    std::vector<std::vector<std::uint32_t>> drawn(set.structures.size());
    for (std::uint32_t k = 0; k < set.slices.size(); ++k)
        for (const Contour& contour : set.contours_of(set.slices[k])) {
            std::vector<std::uint32_t>& of_structure = drawn[contour.structure];
            if (of_structure.empty() || of_structure.back() != k) of_structure.push_back(k);
        }
    for (std::uint32_t s = 0; s < drawn.size(); ++s) warn_of_absence(set, s, drawn[s], heights, context);
    warn_of_distance(set, heights, context);
}

}  // namespace anatomesh
