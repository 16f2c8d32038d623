// SliceCoverage: what each slice of a set says of each structure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/slices/arrangement/slice_arrangement.h"

namespace anatomesh {

enum class Coverage : std::uint8_t {
    drawn,         // the slice has a contour of the structure
    interpolated,  // it has one that nobody drew (Slice::interpolated)
    absent,        // it has none, and this means that the structure is not there
    // It has none, and the structure skips it in the order of the set, but the slices are no stack, so the
    // order says little. The field takes the structure as absent; measures and weights leave the slice out.
    doubtful,
    unknown  // it has none, and this says nothing about the structure
};

// A matrix of slices and structures. A slice that the user left out is no slice of the set and has no row; its
// heights come from heights_left_out() (covering_slices.h).
class SliceCoverage {
  public:
    SliceCoverage() = default;
    // The set's contours alone: drawn, interpolated or absent. O(contours + slices x structures).
    explicit SliceCoverage(const ContourSet& set);

    Coverage at(std::uint32_t slice, std::uint32_t structure) const {
        return of_[static_cast<std::size_t>(slice) * structures_ + structure];
    }
    bool is_drawn(std::uint32_t slice, std::uint32_t structure) const {
        return at(slice, structure) <= Coverage::interpolated;
    }
    bool is_unknown(std::uint32_t slice, std::uint32_t structure) const {
        return at(slice, structure) == Coverage::unknown;
    }
    // Whether what the slice shows of the structure is to be measured: something drawn, or nothing for sure.
    bool is_certain(std::uint32_t slice, std::uint32_t structure) const {
        return at(slice, structure) <= Coverage::absent;
    }
    bool has_unknown() const { return std::find(of_.begin(), of_.end(), Coverage::unknown) != of_.end(); }

    // Says of a structure without a contour on the slice how far its absence is known; a contour stays drawn.
    void set_absence(std::uint32_t slice, std::uint32_t structure, Coverage coverage) {
        Coverage& now = of_[static_cast<std::size_t>(slice) * structures_ + structure];
        if (now > Coverage::interpolated) now = coverage;
    }

  private:
    std::size_t structures_ = 0;
    std::vector<Coverage> of_;  // at slice * structures + structure
};

// What each slice says of each structure; on slices without a contour of it:
// - In a set that says all (a label map: says_all()) and is a stack or sweep, the structure is absent.
// - In any other stack or sweep the slices between a structure's own that covering_slices() does not name are
//   unknown. Where there are such, the slices beyond its ends are unknown too.
// - Along paths a slice says by these rules what its own path draws; all other structures are unknown.
// - Where slices cross, a slice is unknown where those that cross it show the structure on its plane
//   (undrawn_structures.h), where it runs across a stack (stack_and_crossing.h), and where the structure is
//   drawn on slices of about its direction on both sides of it, at a spacing of its own (covering_slices.h).
//   Slices that the structure skips in the order of the set are doubtful.
// - Of structures that lie in each other (overlaps/priority.h) each level decides for its own structures;
//   slices that the level has none of are unknown, or doubtful where slices cross.
// The rules are guesses from the drawing. `arrangement`: of the set. Same result at any number of threads.
// Complexity: O(structures x slices log slices + contours); where slices cross, that of compare_planes().
SliceCoverage coverage_of(const ContourSet& set, const SliceArrangement& arrangement, RunContext& context);

// How the slices of one set lie and what they say: computed once, when a set is prepared, and carried along.
struct SliceFacts {
    SliceArrangement arrangement;
    SliceCoverage coverage;
};
SliceFacts slice_facts_of(const ContourSet& set, double max_gap, RunContext& context);

}  // namespace anatomesh
