// What a user is told of how neighbouring slices were joined, where that is a guess.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/stack/slice_knots.h"
#include "anatomesh/field/stack/structure_stack.h"
#include "anatomesh/slices/coverage/few_slices.h"

namespace anatomesh {

// Gaps that were joined or left open (W-FLD-001, -002, -009), slices without the structure (-003, -012), and a
// part on one slice that cannot end flat (-004).
void warn_about_knots(const ContourSet& set, std::uint32_t structure, const StructureKnots& knots,
                      RunContext& context);

// W-FLD-021, once for each way in which the thickness is known: structures that are drawn on one slice alone, so that
// nothing drawn shows how they go on above and below; those on two where neither the user nor the source says how thick
// slices are; and those that slices beside them end sooner than the user says. `made_mm`: of each, how thick a slice came out.
void warn_about_few_slices(const ContourSet& set, const std::vector<FewSlices>& few,
                           const std::vector<double>& made_mm, RunContext& context);

// W-FLD-005, once for each structure: neighbouring slices on which it has no point in common, as seen along
// the normal, so that what is between them is a guess. `slice_of_map`: of the distance maps that the stacks
// go by.
void warn_about_jumps(const ContourSet& set, std::span<const StructureStack> stacks,
                      std::span<const std::uint32_t> slice_of_map, RunContext& context);

// W-FLD-010, once for each structure, with the worst of it: outlines that overlap several of the next slice
// each, while there are more of them or fewer, so that nothing drawn tells which becomes which. `frame`: the
// plane that heights count from.
void warn_about_ambiguities(const ContourSet& set, std::span<const StructureStack> stacks,
                            std::span<const std::uint32_t> slice_of_map, const Plane& frame,
                            RunContext& context);

}  // namespace anatomesh
