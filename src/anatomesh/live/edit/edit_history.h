// EditHistory: a drawing with the steps that led to it, each of which can be undone and redone.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/live/edit/edit.h"

namespace anatomesh {

// Steps have no limit of number. A new edit drops the steps that were undone. Looking at a drawing is no step.
//
// Each of the three moves takes a function `keep`, which may be empty. It is called once the move is known to be right and
// before anything changes, so that a log can be written first; where it fails, nothing changes and its error is returned.
// Not thread-safe; drawings that it gave may be used on any thread.
class EditHistory {
  public:
    using Keep = std::function<Status()>;

    explicit EditHistory(Drawing first = Drawing()) : drawing_(std::move(first)) {}

    const Drawing& drawing() const { return drawing_; }
    // Steps that can be undone, the oldest first, and steps that can be redone, the next one last.
    std::span<const Edit> done() const { return done_; }
    std::span<const Edit> undone() const { return undone_; }

    // Errors: those of applied(); that of `keep`. Complexity: that of applied().
    Status apply(Edit edit, const Keep& keep = {}, CrossingCheck crossings = CrossingCheck::yes);

    // Each returns false, and changes nothing, where there is no step. Error: that of `keep`. Complexity: that of
    // taken_back().
    Result<bool> undo(const Keep& keep = {});
    Result<bool> redo(const Keep& keep = {});

  private:
    Drawing drawing_;
    std::vector<Edit> done_, undone_;
};

}  // namespace anatomesh
