// try_outcome: what came of one run of the method, as far as it decides whether it is run again
// (retry_policy.h).
#pragma once

#include <cstddef>
#include <cstdint>

#include "anatomesh/base/result.h"
#include "anatomesh/pipeline/model/model.h"

namespace anatomesh {

// What came of a run.
struct RunScore {
    bool kept_contract = false;
    bool size_matters = false;     // where not kept: what is broken may hold with another edge length
    bool reduced_effort = false;   // less was done for the shape of cells than can be
    bool torn = false;             // of a structure that a finer edge length may keep whole
    bool conformed = false;        // contour segments were split for each other's sake
    bool conformed_badly = false;  // and single cells are ill-shaped
    bool deviates = false;         // and its surface goes far from the field's
    bool lacks_contours = false;   // clause 2 of the contract was measured and not met
    bool contradicted = false;     // slices draw otherwise than those that they cross, or it is not known
    double missed = 0;             // share of the contour segments that are no chains of edges of the surface
    long long components_and_handles = 0;  // components and handles of all structures
    // Places where planes cross and surfaces are joined otherwise than drawn.
    std::size_t spurious_joints = 0;
    std::size_t unmet_clauses = 0;  // clauses of the contract that were measured and not met
    double farthest = 0;            // of its surface from the field's, in edge lengths
    double over_bound = 0;          // share of the tetrahedra above the radius-edge ratio, in [0, 1]
    double unforced = 0;            // share of ill-shaped ones that nothing forces; as the next
    double bad = 0;                 // share of those of which clause 4 allows not one that nothing forces
    std::size_t cells = 0;          // also where the contract was not kept
};

// What a run knows of itself beside its report.
struct RunFacts {
    double size_mm = 0;           // the edge length aimed at
    std::size_t cells = 0;        // as far as it came
    bool reduced_effort = false;  // these as in RunScore
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
RunScore score_of(const Result<Model>& model, const ModelReport& report, const RunFacts& facts);

}  // namespace anatomesh
