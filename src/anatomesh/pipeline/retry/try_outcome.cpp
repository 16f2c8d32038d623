#include "anatomesh/pipeline/retry/try_outcome.h"

#include <algorithm>
#include <cmath>

#include "anatomesh/measure/report.h"

namespace anatomesh {

namespace {

double share(std::uint64_t part, std::uint64_t whole) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, whole));
}

// What the report of a model that keeps the contract tells: over_bound, tangles, unmet and lacks_contours.
void add_report(TryOutcome& outcome, const ModelReport& report) {
    outcome.over_bound = report.quality.radius_edge_share_over_2;
    for (const Clause& clause : report.certificate) {
        if (clause.state == ClauseState::kept) continue;
        ++outcome.unmet;
        outcome.lacks_contours = outcome.lacks_contours || clause.number == 2;
    }
    for (const StructureReport& structure : report.structures)
        outcome.tangles += static_cast<long long>(structure.components) + structure.genus;
}

// Of the drawn segments, also those that contours left: the fewer the better.
double share_missed(const ModelReport& report, const RunFacts& facts) {
    std::uint64_t segments = 0, on_surface = 0;
    for (const StructureReport& structure : report.structures) {
        segments += structure.contour_segments;
        on_surface += structure.contour_segments_on_surface;
    }
    return share(std::max(segments - on_surface, facts.segments_missed), facts.drawn_segments);
}

}  // namespace

TryOutcome outcome_of(const Result<Model>& model, const ModelReport& report, const RunFacts& facts) {
    TryOutcome outcome;
    outcome.kept_contract = model.ok();
    outcome.spared_work = facts.spared_work;
    outcome.conformed = facts.conformed;
    outcome.cells = facts.cells;
    outcome.unforced = share(report.listed_cells_total - report.listed_cells_forced, facts.cells);
    outcome.bad = share(report.listed_cells_bad, facts.cells);
    if (!model.ok()) {
        outcome.size_matters = model.error().code == "E-PIP-002" || model.error().code == "E-CUT-001";
        return outcome;
    }
    add_report(outcome, report);
    if (facts.has_segments_beside && !outcome.lacks_contours) {
        outcome.lacks_contours = true;
        ++outcome.unmet;
    }
    outcome.tore_walls = facts.tore_walls;
    outcome.untold = facts.untold;
    outcome.astray = facts.astray;
    outcome.contradicted = facts.contradicted;
    outcome.conformed_badly = facts.conformed && (report.listed_cells_bad > 0 || facts.astray);
    outcome.farthest =
        report.field_distance.at_least ? HUGE_VAL : report.field_distance.max_mm / facts.size_mm;
    outcome.missed = share_missed(report, facts);
    return outcome;
}

}  // namespace anatomesh
