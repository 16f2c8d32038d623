// covering_slices: which slices of a stack say something about a structure that they do not draw.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

// Those from the first to the last slice that a structure is drawn on, by their places in a stack: as a rule
// all, and it is empty on those that do not draw it. But a structure may be drawn on slices of its own, at
// its own spacing, and others between these, for others' sake, say nothing about it. This is a guess, so it is
// warned of (W-FLD-012):
// - where it has three slices or more, and most of its gaps hold others: its own alone cover it;
// - where it has four or more, and all its gaps are as wide (within 5 % of the first): its own alone cover
//   it;
// - where its gaps that hold none are even (two in three of them, three at least, within 5 % of their lower
//   median): one that holds others and is as wide as these is not a gap, and what is in it does not cover it.
//   One twice as wide is: there it was not drawn where it would have been, unless it was, on slices
//   `left_out` of the set that part the gap as wide.
// `drawn`: rising, at least one; `heights`: of all slices, rising; empty where they are not known, then by
// the first rule alone. Complexity: O(n log n).
std::vector<std::uint32_t> covering_slices(const std::vector<std::uint32_t>& drawn,
                                           const std::vector<double>& heights,
                                           const std::vector<double>& left_out = {});

// Rising: how far along `way`, from `middle`, the slices lie that drew the structure and were left out, if
// they lie across it.
std::vector<double> heights_left_out(const ContourSet& set, std::uint32_t structure, Vec3 middle, Vec3 way);

}  // namespace anatomesh
