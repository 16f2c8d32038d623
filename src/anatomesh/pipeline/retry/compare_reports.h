// is_no_worse: whether one of two models of the same contours may be taken for the sake of a single figure.
#pragma once

#include <span>

#include "anatomesh/base/contract.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/measure/report.h"

namespace anatomesh {

// A model as its user would learn of it: `report` filled by measure_model(), and all warnings.
struct ComparedModel {
    const ModelReport& report;
    std::span<const Warning> warnings;
};

// What counts as no worse, whatever the other model has.
struct CompareOptions {
    double near_mm = 0;          // a surface so near to the field's counts as on it. mm, [0, any]
    double farther = 1.05;       // than the other model, in its distance from the field. [1, any]
    double over_bound = 0.0005;  // share of the cells above the radius-edge bound. [0, 1]
    double largest_ratio = contract::nearly_bad_radius_edge;  // [2, any]
    double most_cells = 2;                                    // times those of the other model. [1, any]
};

// True if `model` has no figure that a user looks at worse than `other` has: clauses of the certificate;
// components, genus and pieces of each structure, shells that no contour tells of, contour vertices and
// segments on the surface; slices whose cut is wrong and the worst of them; distance from the field, and what
// is joined that it has apart; the mean ratio, cells above the bound, below 10 degrees or bad without a
// reason, the largest ratio and the smallest dihedral angle; warnings of each code; all of it as the options
// have it. Requires: the same structures, in one order. O(structures + cuts + warnings^2).
bool is_no_worse(const ComparedModel& model, const ComparedModel& other, const CompareOptions& options);

}  // namespace anatomesh
