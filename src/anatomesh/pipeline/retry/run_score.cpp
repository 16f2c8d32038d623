#include "anatomesh/pipeline/retry/run_score.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "anatomesh/base/contract.h"
#include "anatomesh/measure/report.h"

namespace anatomesh {

namespace {

// So few missed segments count as none. [share of the segments; 0 to 1; M 2026-11, bench/arrangements.py]
constexpr double few_missed = 0.005;
// A result that keeps all else may miss so much. [share of the segments; few_missed to 1; M 2026-11-30, random solids on
// crossing stacks]
constexpr double most_missed_of_whole = 0.05;
// The next class of missed segments begins at so many times the one before. [ratio; > 1; M 2026-11, bench/arrangements.py]
constexpr double wider_missed = 4.0 / 3;
// More bad cells are no single ones any more. [share of the cells; 0 to 1; M 2026-11, set not recorded]
constexpr double some_bad = 1e-3;
// A surface further off the field's is a spike. [edge lengths; > 0; M 2026-11, set not recorded]
constexpr double spike_distance = 0.75;
// The next class of cells over the bound begins at so many times the one before: a run with shorter edges is
// not taken for less. [ratio; > 1; M 2026-11, bench/arrangements.py]
constexpr double wider_over_bound = 2;

double share(std::uint64_t part, std::uint64_t whole) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, whole));
}

// 0 up to `first`, then one more each time that a value grows by the factor.
double class_of(double value, double first, double factor) {
    return value <= first ? 0 : 1 + std::floor(std::log(value / first) / std::log(factor));
}

// What the report of a model that keeps the contract tells: over_bound, clauses, components and handles.
void add_report(RunScore& score, const ModelReport& report, bool has_segments_beside) {
    score.over_bound = report.quality.radius_edge.share_over_2;
    bool lacks_contours = has_segments_beside;  // clause 2
    for (const Clause& clause : report.certificate) {
        if (clause.state == ClauseState::kept || clause.state == ClauseState::moved) continue;
        if (clause.number == 2)
            lacks_contours = true;
        else
            ++score.unmet_clauses;
    }
    score.unmet_clauses += lacks_contours;
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

RunOutcome outcome_of(const Result<Model>& model, const ModelReport& report, const RunFacts& facts) {
    RunOutcome outcome;
    RunScore& score = outcome.score;
    RunCourse& course = outcome.course;
    course.can_do_more = facts.can_do_more;
    course.conformed = facts.conformed;
    course.contradicted = facts.contradicted;
    course.cells = facts.cells;
    course.unforced = share(report.listed_cells.total - report.listed_cells.forced, facts.cells);
    score.kept_contract = model.ok();
    if (!model.ok()) {
        course.size_matters = model.error().code == "E-PIP-002" || model.error().code == "E-CUT-001";
        return outcome;
    }
    add_report(score, report, facts.has_segments_beside);
    score.bad = share(report.listed_cells.bad, facts.cells);
    score.torn = facts.torn;
    score.spurious_joints = facts.spurious_joints;
    score.deviates = facts.deviates;
    score.farthest = report.field.distance.at_least ? HUGE_VAL : report.field.distance.max_mm / facts.size_mm;
    score.missed = share_missed(report, facts);
    return outcome;
}

namespace {

// Whether all is kept that is promised.
bool is_whole(const RunScore& score) {
    return score.unmet_clauses == 0 && score.spurious_joints == 0 && !score.torn && score.bad <= few_bad &&
           score.farthest <= warned_distance && score.missed <= most_missed_of_whole;
}

}  // namespace

bool is_better(const RunScore& one, const RunScore& other) {
    // The less the better, in the order of the header.
    const auto criteria = [](const RunScore& score) {
        return std::array{static_cast<double>(!score.kept_contract),
                          static_cast<double>(score.torn),
                          static_cast<double>(score.farthest > spike_distance),
                          static_cast<double>(score.bad > some_bad),
                          static_cast<double>(!is_whole(score)),
                          class_of(score.missed, few_missed, wider_missed),
                          static_cast<double>(score.unmet_clauses),
                          static_cast<double>(score.spurious_joints),
                          static_cast<double>(score.farthest > warned_distance || score.deviates),
                          static_cast<double>(score.bad > 0) + static_cast<double>(score.bad > few_bad),
                          static_cast<double>(score.components_and_handles),
                          class_of(score.over_bound, contract::share_over_bound, wider_over_bound)};
    };
    return criteria(one) < criteria(other);
}

}  // namespace anatomesh
