#include "anatomesh/live/livewire/shortest_paths.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace anatomesh {

namespace {

// Labels in the queue differ by a step's cost at most. [1; a power of two; D]
constexpr std::uint32_t buckets = most_step_cost + 1;

[[maybe_unused]] bool lies_in_picture(const PixelWindow& window, const PictureGrid& grid) {
    return window.left < window.right && window.right <= grid.size[0] && window.top < window.bottom &&
           window.bottom <= grid.size[1];
}

}  // namespace

ShortestPaths::ShortestPaths(const LivewireCosts& costs)
    : costs_(&costs), labels_(costs.grid.count(), unreached), queue_(costs.grid.count(), buckets) {
    const auto width = static_cast<std::int64_t>(costs.grid.size[0]);
    const auto way = [&](int i, int j, StepDirection direction, bool forward) {
        const std::int64_t offset = j * width + i;
        const auto keeper = forward ? 0 : static_cast<std::int64_t>(step_directions) * offset;
        return Way{i, j, offset, keeper + static_cast<std::int64_t>(direction)};
    };
    ways_ = {way(1, 0, StepDirection::right, true),      way(-1, 0, StepDirection::right, false),
             way(0, 1, StepDirection::down, true),       way(0, -1, StepDirection::down, false),
             way(1, 1, StepDirection::down_right, true), way(-1, -1, StepDirection::down_right, false),
             way(-1, 1, StepDirection::down_left, true), way(1, -1, StepDirection::down_left, false)};
}

template <class Visit>
void ShortestPaths::for_each_in_window(const Visit& visit) const {
    for (std::uint32_t j = window_.top; j < window_.bottom; ++j) {
        for (std::uint32_t i = window_.left; i < window_.right; ++i) visit(costs_->grid.index({i, j}));
    }
}

void ShortestPaths::start(std::uint32_t source, const PixelWindow& window) {
    assert(lies_in_picture(window, costs_->grid) && window.contains(costs_->grid.pixel(source)));
    for_each_in_window([&](std::uint32_t pixel) { labels_[pixel] = unreached; });
    queue_.clear();
    window_ = window;
    source_ = source;
    least_label_ = 0;
    escape_ = unreached;
    labels_[source] = 0;
    queue_.push(source, 0);
}

void ShortestPaths::grow(const PixelWindow& window) {
    assert(lies_in_picture(window, costs_->grid) && window.contains(window_));
    // A path that has left the window costs escape_ at least, so what is settled below that is settled for good. The
    // rest of the tree is cut off, and the queue is filled again from what stays.
    const std::uint32_t kept_cost = escape_;
    std::vector<std::uint32_t> kept;
    for_each_in_window([&](std::uint32_t pixel) {
        if (is_settled(pixel) && labels_[pixel] <= kept_cost) {
            kept.push_back(pixel);
        } else {
            labels_[pixel] = unreached;
        }
    });
    queue_.clear();
    window_ = window;
    escape_ = unreached;
    least_label_ = std::min(least_label_, kept_cost);
    if (kept.empty()) {
        labels_[source_] = 0;
        queue_.push(source_, 0);
    }
    for (const std::uint32_t pixel : kept) expand(pixel);
}

bool ShortestPaths::leads_into(const PixelWindow& window, Pixel p, const Way& way) const {
    const std::int64_t i = std::int64_t{p.i} + way.i, j = std::int64_t{p.j} + way.j;
    return i >= window.left && i < window.right && j >= window.top && j < window.bottom;
}

inline void ShortestPaths::relax(std::uint32_t pixel, const Way& way) {
    const auto neighbour = static_cast<std::uint32_t>(pixel + way.offset);
    const std::uint32_t before = labels_[neighbour];
    if (before <= labels_[pixel]) return;  // half of them, without a look at the cost
    const std::uint32_t label = labels_[pixel] + step_cost(pixel, way);
    if (label >= before) return;
    if (before != unreached) queue_.remove(neighbour, before);
    labels_[neighbour] = label;
    queue_.push(neighbour, label);
}

void ShortestPaths::expand(std::uint32_t pixel) {
    const Pixel p = costs_->grid.pixel(pixel);
    const bool inner =
        p.i > window_.left && p.i + 1 < window_.right && p.j > window_.top && p.j + 1 < window_.bottom;
    if (inner) {
        for (const Way& way : ways_) relax(pixel, way);
        return;
    }
    const PixelWindow picture{0, 0, costs_->grid.size[0], costs_->grid.size[1]};
    for (const Way& way : ways_) {
        if (leads_into(window_, p, way)) {
            relax(pixel, way);
        } else if (leads_into(picture, p, way)) {
            escape_ = std::min(escape_, labels_[pixel] + step_cost(pixel, way));
        }
    }
}

std::uint32_t ShortestPaths::settle(std::uint32_t pixel) {
    assert(window_.contains(costs_->grid.pixel(pixel)));
    while (!is_settled(pixel)) expand(queue_.pop(least_label_));
    return labels_[pixel];
}

bool ShortestPaths::settle_next(std::uint32_t count) {
    for (; count > 0 && !queue_.empty(); --count) expand(queue_.pop(least_label_));
    return queue_.empty();
}

std::vector<std::uint32_t> ShortestPaths::path(std::uint32_t pixel) const {
    assert(is_settled(pixel));
    const PictureGrid& grid = costs_->grid;
    const PixelWindow picture{0, 0, grid.size[0], grid.size[1]};
    const Vec2 start = grid.position(grid.pixel(source_));
    const Vec2 along = grid.position(grid.pixel(pixel)) - start;
    std::vector<std::uint32_t> path{pixel};
    while (path.back() != source_) {
        const std::uint32_t here = path.back();
        std::uint32_t nearest = here;
        double least = 0;
        for (const Way& way : ways_) {
            if (!leads_into(picture, grid.pixel(here), way)) continue;
            const auto before = static_cast<std::uint32_t>(here + way.offset);
            // Whatever the label says, it was settled before: its cost is less by a whole step.
            if (labels_[before] == unreached || labels_[before] + step_cost(here, way) != labels_[here])
                continue;
            const double aside = std::abs(cross(along, grid.position(grid.pixel(before)) - start));
            if (nearest == here || aside < least || (aside == least && before < nearest)) {
                nearest = before;
                least = aside;
            }
        }
        assert(nearest != here);
        path.push_back(nearest);
    }
    std::reverse(path.begin(), path.end());
    return path;
}

}  // namespace anatomesh
