#include "anatomesh/improve/climb/hill_climber.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/base/sort_distinct.h"
#include "anatomesh/improve/core/quality_gate.h"
#include "anatomesh/mesh/model/prefetch.h"
#include "anatomesh/mesh/shape/cell_shape.h"

namespace anatomesh {

namespace {

// Cells that a thread looks at in a row. [cells; > 0; B]
constexpr std::size_t cells_in_a_row = 16384;
// A pass over the queue is repeated if it made better at least one cell in so many that are left. [cells; >
// 0; B]
constexpr std::size_t worth_repeating = 50;

// The rule of a pass, until the end of a scope. The deviation bound is no part of it.
class RuleScope {
  public:
    RuleScope(EditContext& edit, const AcceptanceRule& rule)
        : edit_(edit), before_(std::exchange(edit.rule, rule)) {}
    ~RuleScope() { edit_.rule = before_; }
    RuleScope(const RuleScope&) = delete;
    RuleScope& operator=(const RuleScope&) = delete;

  private:
    EditContext& edit_;
    AcceptanceRule before_;
};

}  // namespace

bool HillClimber::is_above(double ratio, std::uint32_t c) const {
    const Cell& v = edit_.mesh.cell(c);
    return squared_radius_edge(edit_.mesh.point(v[0]), edit_.mesh.point(v[1]), edit_.mesh.point(v[2]),
                               edit_.mesh.point(v[3])) > ratio * ratio;
}

bool HillClimber::is_exempt(const ClimbProfile& profile, std::uint32_t c, double sine) const {
    if (profile.exempt == Exempt::none || !edit_.drawn->are_constraint_limited(edit_.mesh.cell(c)))
        return false;
    return profile.exempt == Exempt::limited || sine >= least_limited_sine;
}

bool HillClimber::has_small_sine(const ClimbProfile& profile, std::uint32_t c, double sine) const {
    return sine < profile.target_sine && !is_exempt(profile, c, sine);
}

bool HillClimber::is_bad(const ClimbProfile& profile, std::uint32_t c) const {
    if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return false;
    if (profile.target_ratio < HUGE_VAL && is_above(profile.target_ratio, c))
        return profile.exempt == Exempt::none || !edit_.drawn->are_constraint_limited(edit_.mesh.cell(c));
    return profile.target_sine > 0 && has_small_sine(profile, c, edit_.sine(c));
}

std::vector<std::uint32_t> HillClimber::bad_cells(const ClimbProfile& profile, int threads) const {
    return parallel_collect<std::uint32_t>(
        edit_.mesh.cell_count(), cells_in_a_row, threads,
        [&](std::size_t first, std::size_t last, std::vector<std::uint32_t>& found) {
            for (std::size_t n = first; n < last; ++n) {
                const auto c = static_cast<std::uint32_t>(n);
                if (n + cells_ahead < last)
                    edit_.mesh.prefetch_points(static_cast<std::uint32_t>(n + cells_ahead));
                if (is_bad(profile, c)) found.push_back(c);
            }
        });
}

BadCellQueue HillClimber::queue_of(const ClimbProfile& profile, std::vector<std::uint32_t> cells,
                                   int threads) const {
    sort_distinct(cells);
    return BadCellQueue(parallel_collect<BadCell>(
        cells.size(), cells_in_a_row, threads,
        [&](std::size_t first, std::size_t last, std::vector<BadCell>& bad) {
            for (std::size_t n = first; n < last; ++n) {
                const std::uint32_t c = cells[n];
                if (n + cells_ahead < last) edit_.mesh.prefetch_points(cells[n + cells_ahead]);
                if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) continue;
                if (const double sine = edit_.sine(c); has_small_sine(profile, c, sine))
                    bad.push_back({sine, c});
            }
        }));
}

void HillClimber::climb(const ClimbProfile& profile, BadCellQueue& queue,
                        std::vector<std::uint32_t>& changed) {
    const RuleScope scope(edit_, profile.rule);
    for (int pass = 0; pass < edit_.options.passes && !queue.empty() && !context_.cancelled(); ++pass) {
        QueueResult result = process_queue(profile, queue, context_.threads, changed);
        queue = queue_of(profile, std::move(result.left), context_.threads);
        if (result.gained == 0 || result.gained * worth_repeating < queue.size()) break;
    }
}

std::vector<std::uint32_t> HillClimber::climb_from(const ClimbProfile& profile,
                                                   std::vector<std::uint32_t> cells) {
    const RuleScope scope(edit_, profile.rule);
    std::vector<std::uint32_t> all_changed;
    for (int pass = 0; pass < edit_.options.passes; ++pass) {
        BadCellQueue queue = queue_of(profile, cells, 1);
        if (queue.empty()) break;
        std::vector<std::uint32_t> changed;
        const QueueResult result = process_queue(profile, queue, 1, changed);
        cells.insert(cells.end(), changed.begin(), changed.end());
        all_changed.insert(all_changed.end(), changed.begin(), changed.end());
        if (result.gained == 0 || all_changed.size() > profile.most_changed) break;
    }
    return all_changed;
}

HillClimber::QueueResult HillClimber::process_queue(const ClimbProfile& profile, BadCellQueue& queue,
                                                    int threads, std::vector<std::uint32_t>& changed) {
    QueueResult result;
    const std::size_t before = changed.size();
    while ((!queue.empty() || !speculation_.empty()) && changed.size() - before <= profile.most_changed) {
        const EvaluatedCell worst = speculation_.take_worst(queue, threads);
        if (!queue.empty()) edit_.mesh.prefetch_round(queue.worst().cell);
        const std::uint32_t cell = worst.bad.cell;
        if (!worst.bad.is_current(edit_)) continue;
        ++edit_.stats.tries;
        ++visits_;
        const Cell vertices = edit_.mesh.cell(cell);
        if (!improve(profile.operations, cell, speculation_.is_valid_for(cell) ? &worst : nullptr)) {
            result.left.push_back(cell);
            continue;
        }
        ++result.gained;
        speculation_.note_change(vertices);
        if (profile.lists_changes) changed.insert(changed.end(), edit_.changed.begin(), edit_.changed.end());
        queue_changed(profile, queue);
    }
    return result;
}

// Queues those of the cells of the last change that are bad.
void HillClimber::queue_changed(const ClimbProfile& profile, BadCellQueue& queue) {
    for (const std::uint32_t c : edit_.changed) {
        speculation_.note_change(edit_.mesh.cell(c));
        if (edit_.mesh.region(c) == 0) continue;
        if (const double sine = edit_.sine(c); has_small_sine(profile, c, sine)) queue.push({sine, c});
    }
}

std::size_t HillClimber::climb_list(const ClimbProfile& profile, std::vector<std::uint32_t> cells,
                                    std::vector<std::uint32_t>& changed, std::size_t most_visits) {
    const RuleScope scope(edit_, profile.rule);
    std::size_t changes = 0;
    for (std::size_t n = 0; n < std::min(cells.size(), most_visits) && !context_.cancelled(); ++n) {
        if (changed.size() > profile.most_changed) break;
        if (!is_bad(profile, cells[n])) continue;
        ++visits_;
        if (!improve_on_condition(profile, cells[n])) continue;
        ++changes;
        changed.insert(changed.end(), edit_.changed.begin(), edit_.changed.end());
        if (profile.revisit == Revisit::none) continue;
        std::copy_if(edit_.changed.begin(), edit_.changed.end(), std::back_inserter(cells),
                     [&](std::uint32_t c) { return profile.revisit == Revisit::all || is_bad(profile, c); });
    }
    return changes;
}

bool HillClimber::improve_on_condition(const ClimbProfile& profile, std::uint32_t cell) {
    const bool has_high_ratio = profile.target_ratio < HUGE_VAL && is_above(profile.target_ratio, cell);
    edit_.rule.objective = has_high_ratio ? Objective::radius_edge : Objective::least_sine;
    const bool relabels = profile.relabels_above <= 0 || is_above(profile.relabels_above, cell);
    const OperationSet operations =
        relabels ? profile.operations : profile.operations.without(CellOperation::relabel);
    switch (profile.condition) {
        case Condition::none:
            return improve(operations, cell, nullptr);
        case Condition::limited_in_bounds:
            return attempt(
                [&] { return improve(operations, cell, nullptr) && keep_limited_bounds(edit_.changed); });
        case Condition::all_good:
            return std::any_of(
                operation_attempts.begin(), operation_attempts.end(), [&](const OperationAttempt& n) {
                    return operations.has(n.kind) && attempt([&] {
                               return attempt_operation(edit_, cell, n) && are_good(edit_.changed);
                           });
                });
    }
    return false;
}

template <class Change>
bool HillClimber::attempt(const Change& change) {
    const OperationCounts counts = edit_.stats.operations;
    edit_.mesh.begin_attempt();
    const bool stays = change();
    edit_.mesh.end_attempt(stays);
    if (!stays) edit_.stats.operations = counts;
    return stays;
}

bool HillClimber::improve(OperationSet operations, std::uint32_t cell, const EvaluatedCell* evaluated) {
    std::size_t n = evaluated ? evaluated->first : 0;
    if (evaluated && evaluated->proposal.counter) {
        if (edit_.carry_out(evaluated->proposal)) return true;
        ++n;
    }
    for (; n < operation_attempts.size(); ++n) {
        const OperationAttempt& next = operation_attempts[n];
        if (operations.has(next.kind) && attempt_operation(edit_, cell, next)) return true;
    }
    return false;
}

// Whether those of the cells that contours limit are within the bounds of forced ones.
bool HillClimber::keep_limited_bounds(const std::vector<std::uint32_t>& cells) const {
    return std::all_of(cells.begin(), cells.end(), [&](std::uint32_t c) {
        if (!edit_.mesh.alive(c) || edit_.mesh.region(c) == 0) return true;
        if (!edit_.drawn->are_constraint_limited(edit_.mesh.cell(c))) return true;
        return edit_.sine(c) >= least_limited_sine && !is_above(most_limited_ratio, c);
    });
}

bool HillClimber::are_good(const std::vector<std::uint32_t>& cells) {
    QualityGate gate(edit_, *edit_.drawn, listed_sine());
    return std::all_of(cells.begin(), cells.end(),
                       [&](std::uint32_t c) { return gate.is_good(c) && gate.is_near(c); });
}

}  // namespace anatomesh
