#include "anatomesh/pipeline/retry/run_score.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/measure/report.h"

namespace anatomesh {

namespace {

double share(std::uint64_t part, std::uint64_t whole) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, whole));
}

// What the report of a model that keeps the contract tells: over_bound, tangles, unmet and lacks_contours.
void add_report(RunScore& score, const ModelReport& report) {
    score.over_bound = report.quality.radius_edge_share_over_2;
    for (const Clause& clause : report.certificate) {
        if (clause.state == ClauseState::kept) continue;
        ++score.unmet_clauses;
        score.lacks_contours = score.lacks_contours || clause.number == 2;
    }
    for (const StructureReport& structure : report.structures)
        score.components_and_handles +=
            static_cast<long long>(structure.surface.components) + structure.surface.genus;
}

// Of the drawn segments, also those that contours left: the fewer the better.
double share_missed(const ModelReport& report, const RunFacts& facts) {
    std::uint64_t segments = 0, on_surface = 0;
    for (const StructureReport& structure : report.structures) {
        segments += structure.fidelity.segments;
        on_surface += structure.fidelity.segments_on_surface;
    }
    return share(std::max(segments - on_surface, facts.segments_missed), facts.drawn_segments);
}

}  // namespace

RunScore score_of(const Result<Model>& model, const ModelReport& report, const RunFacts& facts) {
    RunScore score;
    score.kept_contract = model.ok();
    score.reduced_effort = facts.reduced_effort;
    score.conformed = facts.conformed;
    score.cells = facts.cells;
    score.unforced = share(report.listed_cells.total - report.listed_cells.forced, facts.cells);
    score.bad = share(report.listed_cells.bad, facts.cells);
    if (!model.ok()) {
        score.size_matters = model.error().code == "E-PIP-002" || model.error().code == "E-CUT-001";
        return score;
    }
    add_report(score, report);
    if (facts.has_segments_beside && !score.lacks_contours) {
        score.lacks_contours = true;
        ++score.unmet_clauses;
    }
    score.torn = facts.torn;
    score.spurious_joints = facts.spurious_joints;
    score.deviates = facts.deviates;
    score.contradicted = facts.contradicted;
    score.conformed_badly = facts.conformed && (report.listed_cells.bad > 0 || facts.deviates);
    score.farthest = report.field.distance.at_least ? HUGE_VAL : report.field.distance.max_mm / facts.size_mm;
    score.missed = share_missed(report, facts);
    return score;
}

}  // namespace anatomesh
