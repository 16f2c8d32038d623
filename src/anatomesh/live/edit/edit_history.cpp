#include "anatomesh/live/edit/edit_history.h"

#include <utility>

namespace anatomesh {

namespace {

Status kept(const EditHistory::Keep& keep) {
    return keep ? keep() : Status(Nothing{});
}

}  // namespace

Status EditHistory::apply(Edit edit, const Keep& keep, CrossingCheck crossings) {
    ANATOMESH_TRY(Drawing next, applied(drawing_, edit, crossings));
    ANATOMESH_CHECK_STATUS(kept(keep));
    drawing_ = std::move(next);
    done_.push_back(std::move(edit));
    undone_.clear();
    return Nothing{};
}

Result<bool> EditHistory::undo(const Keep& keep) {
    if (done_.empty()) return false;
    Drawing next = taken_back(drawing_, done_.back());
    ANATOMESH_CHECK_STATUS(kept(keep));
    drawing_ = std::move(next);
    undone_.push_back(std::move(done_.back()));
    done_.pop_back();
    return true;
}

Result<bool> EditHistory::redo(const Keep& keep) {
    if (undone_.empty()) return false;
    // What is applied again stood once: the inverse of the inverse is taken back.
    Drawing next = taken_back(drawing_, inverse(undone_.back()));
    ANATOMESH_CHECK_STATUS(kept(keep));
    drawing_ = std::move(next);
    done_.push_back(std::move(undone_.back()));
    undone_.pop_back();
    return true;
}

}  // namespace anatomesh
