// SpeculativeEvaluation: operations on bad cells that several threads evaluate before their turn comes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/improve/climb/bad_cell_queue.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// A bad cell, and what the evaluation found: the attempts (cell_operations.h) before `first` fail, and that
// one may succeed.
struct EvaluatedCell {
    BadCell bad;
    std::size_t first = 0;
    Proposal proposal;  // the change that the attempt `first` would make
};

// Takes the worst cells off a queue, many at a time, and evaluates the cheap operations on all threads. The
// changes of the mesh are the same without it: what was evaluated is used only if no cell with a vertex of
// the cell in question has changed since. Complexity: as the operations; memory O(points).
class SpeculativeEvaluation {
  public:
    explicit SpeculativeEvaluation(EditContext& edit) : edit_(edit) {}

    // No evaluated cell waits for its turn.
    bool empty() const { return next_ == evaluated_.size(); }
    // The worst cell of the queue and of those that wait. On one thread nothing is evaluated beforehand.
    // Requires: one of both is not empty.
    EvaluatedCell take_worst(BadCellQueue& queue, int threads);

    // Whether what was evaluated of this cell may be used.
    bool is_valid_for(std::uint32_t cell) const;
    // Cells at these vertices have changed.
    void note_change(const Cell& vertices);

  private:
    void evaluate(BadCellQueue& queue, int threads);

    EditContext& edit_;
    std::vector<EvaluatedCell> evaluated_;   // the worst first
    std::size_t next_ = 0;                   // those before it do not wait any more
    std::uint32_t round_ = 0;                // number of the last evaluation
    std::vector<std::uint32_t> changed_in_;  // by vertex: after which round a cell at it changed last
};

}  // namespace anatomesh
