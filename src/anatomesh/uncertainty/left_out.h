// leave_slices_out: how well each slice is foretold by the others.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/field/model/structure_field.h"

namespace anatomesh {

struct LeftOutOptions {
    FieldOptions field;  // as those of the model
    // A slice is foretold by so many nearest ones: the rest hardly matter. Slices; [2, 1000]
    std::uint32_t parallel_neighbors = 8;
    std::uint32_t neighbors = 32;  // of planes in any position
};

// A point of a contour, its slice left out.
struct LeftOutPoint {
    float error_mm = 0;   // from the surface that the other slices give, at most the clamp
    float gap_mm = 0;     // from the nearest contour of its structure on them; at most reach_mm
    bool is_end = false;  // the others end before it: across the contour there is none of their surface
};

// The errors of one slice.
struct SliceError {
    std::uint32_t points = 0;
    double mean_mm = 0, p95_mm = 0, max_mm = 0;
};

struct LeftOut {
    std::vector<LeftOutPoint> points;  // one a point of the set
    std::vector<SliceError> slices;    // one a slice of the set
    double reach_mm = 0;               // beyond it nothing is evidence: four slice spacings
};

// For every slice the field of the others, by the same rules as the model's, and how far from the slice's
// contour points its surface lies along the line across the contour in the slice's plane; where there is none
// (the others end before), half the gap; at most the clamp. Requires: a kept contour set. Guarantees: the same
// at any thread count. Errors: geometry E-UNC-001 fewer than two slices. Complexity: a field of a few slices
// for each slice; parallel over slices. Follows: leave-one-out cross-validation (Stone, J. R. Stat. Soc. B 36,
// 1974).
Result<LeftOut> leave_slices_out(const ContourSet& set, const LeftOutOptions& options, RunContext& context);

}  // namespace anatomesh
