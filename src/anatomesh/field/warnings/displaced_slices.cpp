#include "anatomesh/field/warnings/displaced_slices.h"

#include <algorithm>
#include <string>
#include <vector>

#include "anatomesh/base/number_text.h"
#include "anatomesh/contour/planes/displaced_slices.h"

namespace anatomesh {

namespace {

// A message names no more slices, so that it stays one line. [slices; >= 1; B]
constexpr std::size_t most_named = 5;

}  // namespace

void warn_about_displaced_slices(const ContourSet& set, RunContext& context) {
    if (!set.drawn) return;
    const std::vector<DisplacedSlice> out = find_displaced_slices(set);
    if (out.empty()) return;
    const auto worst = std::max_element(
        out.begin(), out.end(),
        [](const DisplacedSlice& a, const DisplacedSlice& b) { return a.distance_mm < b.distance_mm; });
    std::string names;
    for (std::size_t n = 0; n < std::min(out.size(), most_named); ++n)
        names += (n > 0 ? ", " : "") + set.slices[out[n].slice].name;
    if (out.size() > most_named) names += ", ...";
    const Structure& structure = set.structures[worst->structure];
    const std::string& slice = set.slices[worst->slice].name;
    if (std::any_of(context.warnings.begin(), context.warnings.end(), [&](const Warning& told) {
            return told.code == "W-FLD-011" && told.place.slice == slice;
        }))
        return;
    context.warn(
        {"W-FLD-011",
         "the contours are displaced from the line between the slices before and after, which agree without "
         "it: slice " +
             names,
         {set.source, slice, structure.name.empty() ? std::to_string(structure.number) : structure.name, "",
          brief(worst->distance_mm) + " mm"},
         "kept as drawn; check whether the slice or the patient moved; --without leaves the slice out"});
}

}  // namespace anatomesh
