#include "anatomesh/field/unsaid.h"

#include <algorithm>

#include "anatomesh/field/crossed_field.h"
#include "anatomesh/field/parallel_field.h"
#include "anatomesh/field/sweep.h"
#include "anatomesh/reconcile/silences.h"

namespace anatomesh {

Unsaid Unsaid::of(const ContourSet& set, RunContext& context) {
    Unsaid made;
    if (set.structures.size() < 2 || is_parallel(set) || Sweep::of(set)) return made;
    std::vector<std::vector<bool>> unsaid(set.slices.size(), std::vector<bool>(set.structures.size(), false));
    for (const Silence& silence : find_silences(set, context))
        unsaid[silence.slice][silence.structure] = true;
    if (const auto slices = stack_and_crossing(set)) {
        for (const std::uint32_t s : slices->crossing) {
            unsaid[s].assign(set.structures.size(), true);
            for (const Contour& contour : set.contours_of(set.slices[s]))
                unsaid[s][contour.structure] = false;
        }
    }
    const auto any = [](const std::vector<bool>& of_slice) {
        return std::find(of_slice.begin(), of_slice.end(), true) != of_slice.end();
    };
    if (std::any_of(unsaid.begin(), unsaid.end(), any)) made.unsaid_ = std::move(unsaid);
    return made;
}

}  // namespace anatomesh
