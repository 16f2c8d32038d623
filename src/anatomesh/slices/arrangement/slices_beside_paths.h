// slices_beside_paths: the few slices, or the structures, that keep all others from being slices along paths.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

// A slice that fits no path.
struct SliceBesidePaths {
    std::uint32_t slice = 0;
    // The first slice along a path that it crosses where both draw one structure; nothing: no other slice of its
    // structure is its neighbour.
    std::optional<std::uint32_t> crosses;
};

// By their index, rising.
struct SlicesBesidePaths {
    std::vector<SliceBesidePaths> slices;
    std::vector<std::uint32_t> structures;   // those that follow no path, and share no slice with the others
    std::vector<std::uint32_t> along_paths;  // the others
};

// Slices that follow paths are planes in any position as soon as one of the set does not (paths_of_slices.h). Returns
// those without which the others follow paths: a tenth of the slices at most, or one, or all slices of structures that
// share none with the others. Nothing where the set is parallel, a sweep, along paths, or has overlaps that were given
// to structures; where fewer than five slices are left; and where these lean by less than 60 degrees against each
// other, so that a hand may have led them.
// Complexity: O(slices^2 + points of slices that cross), ten times at most.
std::optional<SlicesBesidePaths> slices_beside_paths(const ContourSet& set,
                                                     const SliceArrangement& arrangement);

// W-FLD-018, once, where there are such.
void warn_about_slices_beside_paths(const ContourSet& set, const SliceArrangement& arrangement,
                                    RunContext& context);

}  // namespace anatomesh
