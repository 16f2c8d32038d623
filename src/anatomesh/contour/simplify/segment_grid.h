// SegmentGrid: which segments of a plane pass near a place.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "anatomesh/geom/box.h"
#include "anatomesh/geom/vec.h"

namespace anatomesh {

// Which segments pass through which cell of a uniform grid of about two cells a segment.
class SegmentGrid {
  public:
    // ends(i): the pair of ends of segment i. Requires: count > 0, finite coordinates. Expected O(count).
    template <class Ends>
    void build(std::uint32_t count, Ends ends) {
        box_ = Box2();
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::pair<Vec2, Vec2> segment = ends(i);
            box_.extend(segment.first);
            box_.extend(segment.second);
        }
        const double width = box_.high.x - box_.low.x, height = box_.high.y - box_.low.y;
        const double cells = 2.0 * count;
        size_ = std::max({std::sqrt(width / cells * height), width / cells, height / cells,
                          std::numeric_limits<double>::min()});
        columns_ = rows_ = 0;
        columns_ = column(box_.high.x) + 1;
        rows_ = row(box_.high.y) + 1;

        // The entries are counted, the counts summed, and the places filled.
        first_.assign(columns_ * rows_ + 1, 0);
        for (std::uint32_t i = 0; i < count; ++i) {
            for_cells(ends(i), [&](std::size_t cell) { ++first_[cell + 1]; });
        }
        for (std::size_t cell = 0; cell < columns_ * rows_; ++cell) first_[cell + 1] += first_[cell];
        entries_.resize(first_.back());
        fill_.assign(first_.begin(), first_.end() - 1);
        for (std::uint32_t i = 0; i < count; ++i) {
            for_cells(ends(i), [&](std::size_t cell) { entries_[fill_[cell]++] = i; });
        }
    }

    // Calls visit(segment) for all segments in the cells that the box touches; some more than once.
    template <class Visit>
    void query(const Box2& box, Visit visit) const {
        const std::size_t x0 = column(box.low.x), x1 = column(box.high.x), y1 = row(box.high.y);
        for (std::size_t y = row(box.low.y); y <= y1; ++y) {
            for (std::size_t x = x0; x <= x1; ++x) {
                const std::size_t cell = y * columns_ + x;
                for (std::uint32_t k = first_[cell]; k < first_[cell + 1]; ++k) visit(entries_[k]);
            }
        }
    }

  private:
    static constexpr double most = 1e9;  // The grid has at most so many columns or rows. [cells; > 0; B]

    std::size_t column(double x) const { return index(x - box_.low.x, columns_); }
    std::size_t row(double y) const { return index(y - box_.low.y, rows_); }
    std::size_t index(double offset, std::size_t count) const {
        const double at = std::clamp(offset / size_, 0.0, most);
        return count == 0 ? static_cast<std::size_t>(at) : std::min(static_cast<std::size_t>(at), count - 1);
    }

    // The cells that the segment passes, row by row; a cell too many does no harm.
    template <class Visit>
    void for_cells(std::pair<Vec2, Vec2> segment, Visit visit) const {
        auto [p, q] = segment;
        if (p.y > q.y) std::swap(p, q);
        const std::size_t y0 = row(p.y), y1 = row(q.y);
        for (std::size_t y = y0; y <= y1; ++y) {
            double from = p.x, to = q.x;
            if (y0 != y1) {
                const double slope = (q.x - p.x) / (q.y - p.y);
                const double bottom = box_.low.y + static_cast<double>(y) * size_;
                if (y != y0) from = p.x + (bottom - p.y) * slope;
                if (y != y1) to = p.x + (bottom + size_ - p.y) * slope;
            }
            const double slack = 1e-6 * size_;
            const std::size_t x1 = column(std::max(from, to) + slack);
            for (std::size_t x = column(std::min(from, to) - slack); x <= x1; ++x) visit(y * columns_ + x);
        }
    }

    Box2 box_;
    double size_ = 1;
    std::size_t columns_ = 0, rows_ = 0;
    std::vector<std::uint32_t> first_, fill_, entries_;
};

}  // namespace anatomesh
