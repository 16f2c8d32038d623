// BadCellQueue: cells with too small an angle, the worst first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <queue>
#include <utility>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"

namespace anatomesh {

// A cell and its least sine when it was found bad.
struct BadCell {
    double sine;
    std::uint32_t cell;

    // The order of a queue with the worst cell on top; of two as bad the one with the smaller number comes
    // first.
    friend bool operator<(const BadCell& a, const BadCell& b) {
        return a.sine != b.sine ? a.sine > b.sine : a.cell > b.cell;
    }

    // Whether the cell is inside and has not changed its sine since.
    bool is_current(const EditContext& edit) const {
        return edit.mesh.alive(cell) && edit.mesh.region(cell) != 0 && edit.sine(cell) == sine;
    }
};

// A cell that changes is queued once more, so a queue may hold entries that are not current. O(log cells)
class BadCellQueue {
  public:
    BadCellQueue() = default;
    explicit BadCellQueue(std::vector<BadCell> cells) : queue_({}, std::move(cells)) {}

    bool empty() const { return queue_.empty(); }
    std::size_t size() const { return queue_.size(); }
    const BadCell& worst() const { return queue_.top(); }
    void push(const BadCell& bad) { queue_.push(bad); }
    BadCell take_worst() {
        const BadCell bad = queue_.top();
        queue_.pop();
        return bad;
    }

    // Empties the queue. Returns the cells, the worst first.
    std::vector<std::uint32_t> take_cells() {
        std::vector<std::uint32_t> cells;
        for (; !empty(); queue_.pop()) cells.push_back(queue_.top().cell);
        return cells;
    }

  private:
    std::priority_queue<BadCell> queue_;
};

}  // namespace anatomesh
