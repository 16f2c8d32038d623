// RunScore: what came of one run of the method, and which of two results is the better one.
//
// Guarantees: is_better() is a strict weak order. It compares criteria one by one, the first that differs decides,
// and each criterion is a number of one run alone. So the best of several runs does not depend on their sequence.
// All functions are O(1) but outcome_of().
#pragma once

#include <cstddef>
#include <cstdint>

#include "anatomesh/base/result.h"
#include "anatomesh/pipeline/model/model.h"

namespace anatomesh {

// How good a result is. Where the contract is broken, nothing else is known.
struct RunScore {
    bool kept_contract = false;
    bool torn = false;      // holes are in a wall that a finer edge length may keep whole
    bool deviates = false;  // planes are dense, and the surface goes far from the field's between them
    double missed = 0;  // share of the contour segments that are no chains of edges of the surface, in [0, 1]
    long long components_and_handles = 0;  // of all structures
    std::size_t spurious_joints =
        0;                          // places where planes cross and surfaces are joined otherwise than drawn
    std::size_t unmet_clauses = 0;  // clauses of the contract that were measured and not met
    // Distance of the surface from the field's, in edge lengths; infinite where only a lower bound is known.
    double farthest = 0;
    double over_bound = 0;  // share of the cells above the radius-edge ratio, in [0, 1]
    double bad = 0;         // share of the cells that clause 4 forbids, in [0, 1]
};

// What says, beside the score, whether another run may do better. It is known of refused runs as well.
struct RunCourse {
    bool size_matters = false;  // the contract is broken in a way that another edge length may mend
    bool can_do_more = false;   // the same size may be tried with more work
    bool conformed = false;     // contour segments were split for each other's sake
    bool contradicted = false;  // slices draw otherwise than those that they cross, or it is not known
    double unforced = 0;        // share of ill-shaped cells that nothing forces, in [0, 1]
    std::size_t cells = 0;      // as far as the run came
};

struct RunOutcome {
    RunScore score;
    RunCourse course;
};

// What a run knows of itself beside its report.
struct RunFacts {
    double size_mm = 0;        // the edge length aimed at
    std::size_t cells = 0;     // as far as it came
    bool can_do_more = false;  // these as in RunCourse and RunScore
    bool conformed = false;
    bool torn = false;
    bool deviates = false;
    bool contradicted = false;
    std::size_t spurious_joints = 0;
    // Contour segments that were no chains of edges, whether their contours are re-routed now or not,
    // and whether some of these have edges beside them in their place.
    std::uint64_t segments_missed = 0;
    bool has_segments_beside = false;
    std::uint64_t drawn_segments = 0;
};

// `report`: of the model, or as far as the run came. Segments with edges beside them in their place count as
// missed, and clause 2 as not met for them: another run may have edges along them. O(structures + clauses)
RunOutcome outcome_of(const Result<Model>& model, const ModelReport& report, const RunFacts& facts);

// With at most this share of bad cells a model is hardly bad: a run without splitting would lose more contour
// segments. [share of the cells; 0 to 1; M 2026-11, docs/experiments/2026-11-28-retries.md]
inline constexpr double few_bad = 1e-4;
// A surface further off the field's than this is warned of (W-PIP-008). [edge lengths; > 0; C]
inline constexpr double warned_distance = 0.5;

// Whether `one` is better than `other`. The criteria, the first that differs decides:
//  1. the contract is kept;
//  2. no wall is torn;
//  3. the surface is no more than 0.75 edge lengths off the field's, which would be a spike;
//  4. at most one cell in 1,000 is bad;
//  5. all is kept that is promised: clauses, joints, walls, at most few bad cells, no surface that is warned of; and at
//     most 5 % of the contour segments are missed;
//  6. fewer contour segments are missed, in classes: up to half a percent of them, then each class a third wider;
//  7. fewer clauses are not met;
//  8. fewer joints are spurious;
//  9. the surface is no more than half an edge length off the field's (W-PIP-008), and does not deviate;
// 10. fewer bad cells, in classes: none, few (`few_bad`), more;
// 11. fewer components and handles;
// 12. fewer cells above the radius-edge ratio, in classes: as many as the contract allows, then each twice as wide.
// Classes make small differences count as none, so that the earlier of two results stays.
bool is_better(const RunScore& one, const RunScore& other);

}  // namespace anatomesh
