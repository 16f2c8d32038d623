// structures_on_few_slices: how thick slices are of structures that too few slices of a stack draw to show it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/parallel_slices.h"

namespace anatomesh {

// One gap between slices may be a stride of the drawing or the space between two parts; two gaps that are alike
// are a stride. [slices; 2; D]
inline constexpr std::size_t most_few_slices = 2;

// Another slice that is nearer says nothing of a structure on few slices: files round the places of slices.
// [thicknesses; 0 to 0.25; C half a tenth of a millimetre beside slices of half a millimetre]
inline constexpr double same_plane_share = 0.12;

// What says how thick a slice is, the strongest first.
enum class ThicknessBy : std::uint8_t {
    option,  // the user
    source,  // ContourSet::slice_thickness_mm
    others,  // the spacing of structures of the set that are drawn on more slices
    nothing
};

// A structure that is drawn on so few slices, and how thick these are.
struct FewSlices {
    std::uint32_t structure = 0;
    std::vector<std::uint32_t> slices = {};  // of the set, rising along the stack
    double mm = 0;                           // 0: nothing says it
    ThicknessBy by = ThicknessBy::nothing;
};

// Returns the structures of a stack that are drawn on most_few_slices at most, in order, with the thickness of
// their slices:
// - `asked_mm` where it is above 0.
// - Else what the source states. Where structures on more slices that are drawn on those of this one, too, lie more than
//   1.5 times as far apart, it is the least of their spacings, because the drawing then leaves out images between.
// - Else the least spacing of such structures, and of any others where there is none.
// - No more than the distance of its own two slices, unless the user says so.
// Nothing for sets whose slices say all (says_all()), because there the slices beside a structure end it.
// `intervals`: of the set. Complexity: O(contours + few x structures).
std::vector<FewSlices> structures_on_few_slices(const ContourSet& set,
                                                const std::vector<SliceInterval>& intervals, double asked_mm);

// Returns the thickness of the slices of one structure; 0 where it is none of `few`, or nothing says it.
double thickness_of(const std::vector<FewSlices>& few, std::uint32_t structure);

// Returns the thickness of slices where all structures that have contours are drawn on few; else, and where
// nothing says it, 0. `few`: of the set.
double thickness_of_all(const ContourSet& set, const std::vector<FewSlices>& few);

// Returns those structures alone; of any set. Complexity: O(contours).
std::vector<std::uint32_t> structures_on_few_slices(const ContourSet& set);

}  // namespace anatomesh
