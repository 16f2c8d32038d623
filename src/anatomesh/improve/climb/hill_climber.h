// HillClimber: local hill climbing on ill-shaped cells, as the profile of a pass says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/improve/climb/bad_cell_queue.h"
#include "anatomesh/improve/climb/climb_profile.h"
#include "anatomesh/improve/climb/speculative_evaluation.h"
#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// A cell that a pass works on is changed by the first operation, in the order of their price, that makes the
// worst of the cells concerned better: by the least sine, or by the ratio where the cell's own is above the
// profile's target. Each pass sets the context's rule and puts it back. Guarantees: as the operations
// (operations.h) and the profile's rule; the same result for any number of threads. Errors: none; a cancelled
// run stops early. Follows: Freitag and Ollivier-Gooch, Int. J. Numer. Methods Eng. 40, 1997; Klingner and
// Shewchuk, Proc. 16th International Meshing Roundtable, 2007.
class HillClimber {
  public:
    // Requires: `edit.drawn` is set; all outlive this.
    HillClimber(EditContext& edit, const RunContext& context)
        : edit_(edit), context_(context), speculation_(edit) {}

    // Whether a pass works on a cell: it is inside, worse than a target, and not exempt.
    bool is_bad(const ClimbProfile& profile, std::uint32_t c) const;
    // All cells of the mesh that a pass works on, rising. O(cells)
    std::vector<std::uint32_t> bad_cells(const ClimbProfile& profile, int threads) const;
    // The cells whose sine is too small for the profile. `cells` in any order, repeats and such that are gone
    // allowed. O(cells log cells)
    BadCellQueue queue_of(const ClimbProfile& profile, std::vector<std::uint32_t> cells, int threads) const;

    // Works through the queue, again and again while that helps, `MeshImprovementOptions::passes` times at
    // most. The queue has what is still bad afterwards. If the profile lists changes, `changed` gets the
    // cells made or reshaped, some of which may be gone.
    void climb(const ClimbProfile& profile, BadCellQueue& queue, std::vector<std::uint32_t>& changed);
    // The same of cells and of all that come of them, on one thread. Returns the cells made or reshaped.
    std::vector<std::uint32_t> climb_from(const ClimbProfile& profile, std::vector<std::uint32_t> cells);
    // Works through a list of cells in its order, `most_visits` of them at most; what the profile revisits is
    // added to the list. Returns the number of changes. `changed` gets the cells made or reshaped.
    std::size_t climb_list(const ClimbProfile& profile, std::vector<std::uint32_t> cells,
                           std::vector<std::uint32_t>& changed,
                           std::size_t most_visits = std::numeric_limits<std::size_t>::max());

    // How many bad cells it tried to improve so far, those of changes taken back included: what goes with its time.
    std::uint64_t visits() const { return visits_; }

  private:
    struct QueueResult {
        std::uint64_t gained = 0;         // cells that were made better
        std::vector<std::uint32_t> left;  // cells that nothing helped
    };
    QueueResult process_queue(const ClimbProfile& profile, BadCellQueue& queue, int threads,
                              std::vector<std::uint32_t>& changed);
    void queue_changed(const ClimbProfile& profile, BadCellQueue& queue);

    bool is_above(double ratio, std::uint32_t c) const;
    bool has_small_sine(const ClimbProfile& profile, std::uint32_t c, double sine) const;
    bool is_exempt(const ClimbProfile& profile, std::uint32_t c, double sine) const;
    bool improve(OperationSet operations, std::uint32_t cell, const EvaluatedCell* evaluated);
    bool improve_on_condition(const ClimbProfile& profile, std::uint32_t cell);
    // Undoes what `change` did to the mesh and the counts unless it says true.
    template <class Change>
    bool attempt(const Change& change);
    bool keep_limited_bounds(const std::vector<std::uint32_t>& cells) const;
    bool are_good(const std::vector<std::uint32_t>& cells);

    EditContext& edit_;
    const RunContext& context_;
    SpeculativeEvaluation speculation_;
    std::uint64_t visits_ = 0;
};

}  // namespace anatomesh
