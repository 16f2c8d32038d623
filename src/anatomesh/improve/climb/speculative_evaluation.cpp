#include "anatomesh/improve/climb/speculative_evaluation.h"

#include <algorithm>
#include <utility>

#include "anatomesh/base/parallel.h"
#include "anatomesh/improve/climb/cell_operations.h"

namespace anatomesh {

namespace {

// More cells at a time would change each other's surroundings before their turn. [cells; > 0; B]
constexpr std::size_t most_evaluated = 1024;
// Of a short queue this part is evaluated at a time, for the same reason. [1; > 0; B]
constexpr std::size_t evaluated_part = 8;
// Fewer cells at a time would not keep the threads at work. [cells; > 0; B]
constexpr std::size_t least_evaluated = 64;
// Cells that a thread takes at a time. [cells; > 0; B]
constexpr std::size_t cells_at_a_time = 16;

// Looks for the first attempt on the cell that may succeed.
void evaluate_cell(EditContext& local_edit, EvaluatedCell& evaluated) {
    Proposal& proposal = local_edit.speculation.proposal;
    proposal = {};
    while (evaluated.first < speculative_attempts &&
           !attempt_operation(local_edit, evaluated.bad.cell, operation_attempts[evaluated.first])) {
        ++evaluated.first;
        proposal = {};
    }
    evaluated.proposal = std::move(proposal);
}

}  // namespace

EvaluatedCell SpeculativeEvaluation::take_worst(BadCellQueue& queue, int threads) {
    if (empty() && threads > 1) evaluate(queue, threads);
    if (!empty() && (queue.empty() || queue.worst() < evaluated_[next_].bad))
        return std::move(evaluated_[next_++]);
    return {queue.take_worst(), 0, {}};
}

void SpeculativeEvaluation::evaluate(BadCellQueue& queue, int threads) {
    const std::size_t part = std::max(queue.size() / evaluated_part, least_evaluated);
    evaluated_.resize(std::min({part, most_evaluated, queue.size()}));
    next_ = 0;
    for (EvaluatedCell& evaluated : evaluated_) evaluated = {queue.take_worst(), 0, {}};
    ++round_;
    changed_in_.resize(edit_.mesh.point_count(), 0);
    parallel_for(evaluated_.size(), cells_at_a_time, threads, [&](std::size_t first, std::size_t last) {
        EditContext local_edit = edit_;
        local_edit.speculation.active = local_edit.speculation.local_only = true;
        for (std::size_t n = first; n < last; ++n) {
            if (evaluated_[n].bad.is_current(edit_)) evaluate_cell(local_edit, evaluated_[n]);
        }
    });
}

bool SpeculativeEvaluation::is_valid_for(std::uint32_t cell) const {
    const Cell& c = edit_.mesh.cell(cell);
    return std::none_of(c.begin(), c.end(),
                        [&](std::uint32_t v) { return v >= changed_in_.size() || changed_in_[v] == round_; });
}

void SpeculativeEvaluation::note_change(const Cell& vertices) {
    for (const std::uint32_t v : vertices) {
        if (v < changed_in_.size()) changed_in_[v] = round_;
    }
}

}  // namespace anatomesh
