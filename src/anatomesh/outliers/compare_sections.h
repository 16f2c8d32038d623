// compare_sections: what a section shows that neither of the two beside it does, and the other way round.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/outliers/section.h"

namespace anatomesh {

// Where the section leaves what lies between its neighbours. Between them is what at least one of them holds and what
// both hold: a surface that goes from one to the other passes there. Parts that are drawn near each other on the three
// are taken together, and the neighbours count as drawn or moved to where the line between their middles is at the
// section, whichever suits the section more, so that tubes across the slices at a low angle do not count.
struct ShapeDifference {
    double excess_mm2 = 0;   // in the section, and in none of its neighbours
    double deficit_mm2 = 0;  // in both neighbours, and not in the section
    double beside_mm2 = 0;   // in one neighbour, and not in the other
    double wide_mm2 = 0;     // the larger of the section's area and the neighbours' mean area
    double share =
        0;  // excess and deficit, of the larger of the section's area and the neighbours' mean area
    double share_of_all = 0;     // the same, of all parts of the section or its neighbours
    double mean_mm = 0;          // excess and deficit over the mean perimeter
    std::uint32_t contour = 0;   // the largest one of the section there
    double shift_mm = 0;         // of that middle, from the line between the neighbours' middles
    double unshifted_share = 0;  // as `share`, were it not shifted
};

enum class TopologyDifferenceKind : std::uint8_t {
    part_missing,  // both neighbours have a part here, one over the other
    part_alone,    // neither has a part within reach
    hole_missing,  // both have a hole here
    hole_alone     // both are solid here
};
struct TopologyDifference {
    TopologyDifferenceKind kind = TopologyDifferenceKind::part_missing;
    std::uint32_t contour = 0;  // it, or that of a neighbour where it is missing
    double area_mm2 = 0;        // of the part or hole
    double share = 0;           // of the larger of the section's area and the neighbours' mean area
    double reach_mm = 0;        // of a part alone: from the nearest one of the neighbours
};

struct SectionComparison {
    ShapeDifference shape;  // of the parts for which `share` is largest
    std::vector<TopologyDifference> topology;
};

// Requires: sections of one structure, below.height < one.height < above.height. Complexity: O(points) times at most
// some thousand cells of a grid.
SectionComparison compare_sections(const Section& below, const Section& one, const Section& above);

}  // namespace anatomesh
