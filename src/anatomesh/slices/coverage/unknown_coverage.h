// UnknownCoverage: the structures of which a slice says nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Of a structure that is not drawn on it a slice says that it is not there, as a rule; but nothing where
// slices that cross it show the structure there (undrawn_structures.h), and nothing where it runs across a
// stack (crossed_field.h): the stack tells where the structure is; and nothing where the structure is drawn
// on slices of about its direction on both sides of it, at a spacing of its own, as covering_slices.h has it
// for a stack. In one stack or sweep every slice covers all.
class UnknownCoverage {
  public:
    static UnknownCoverage of(const ContourSet& set, RunContext& context);

    // Whether the slice says nothing of the structure, which is not drawn there.
    bool contains(std::uint32_t slice, std::uint32_t structure) const {
        return !unknown_.empty() && unknown_[slice][structure];
    }
    bool empty() const { return unknown_.empty(); }

  private:
    std::vector<std::vector<bool>> unknown_;  // by slice and structure; empty: none
};

}  // namespace anatomesh
