// ShortestPaths: the cheapest paths from one pixel to others, found as they are asked for.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "anatomesh/live/livewire/bucket_queue.h"
#include "anatomesh/live/livewire/livewire_costs.h"

namespace anatomesh {

// The pixels of columns [left, right) and rows [top, bottom).
struct PixelWindow {
    std::uint32_t left = 0, top = 0, right = 0, bottom = 0;

    bool contains(Pixel p) const { return p.i >= left && p.i < right && p.j >= top && p.j < bottom; }
    bool contains(const PixelWindow& other) const {
        return other.left >= left && other.right <= right && other.top >= top && other.bottom <= bottom;
    }
    friend bool operator==(const PixelWindow&, const PixelWindow&) = default;
};

// Dijkstra's algorithm on a picture's 8-neighbour graph, confined to a window. It goes on where it stopped: what is
// settled stays so for later questions, and a window that grows keeps all that it cannot change. Costs are whole
// numbers, so the cost of a path is exact and the same in both directions.
// Requires: the costs outlive the object. Memory: 12 bytes for each pixel of the picture.
// Sources: Dijkstra 1959; Dial 1969; Falcao, Udupa and Miyazawa, IEEE TMI 19, 2000 (search on demand).
class ShortestPaths {
  public:
    explicit ShortestPaths(const LivewireCosts& costs);

    // Forgets all paths and begins anew at `source`. O(pixels of the window before).
    // Requires: the window lies in the picture and contains the source.
    void start(std::uint32_t source, const PixelWindow& window);

    // Lets paths go through a larger window. Those that cost no more than escape_cost() stay as they are; the others
    // are found again when they are asked for. O(pixels of the window before).
    // Requires: start(); the window lies in the picture and contains the one before.
    void grow(const PixelWindow& window);

    // Finds the cheapest path in the window to a pixel, and its cost. O(pixels that cost less).
    // Requires: start(); the pixel lies in the window.
    std::uint32_t settle(std::uint32_t pixel);

    // Settles so many further pixels of the window, the cheapest first, and returns whether none is left. O(count).
    // Requires: start().
    bool settle_next(std::uint32_t count);

    // The cheapest way out of the window costs so much at least, as far as is known. A settled pixel that costs no more
    // has the same paths in every larger window. Infinite where the window ends with the picture.
    std::uint32_t escape_cost() const { return escape_; }

    // The cheapest path from the source, both ends included. Of equally cheap ones it is the one whose last pixels are
    // nearest to the straight line between the ends (of equally near ones, the pixel with the smaller index), step by
    // step from the end. O(length). Requires: the pixel is settled.
    std::vector<std::uint32_t> path(std::uint32_t pixel) const;

    bool is_settled(std::uint32_t pixel) const {
        return labels_[pixel] != unreached && !queue_.contains(pixel);
    }
    std::uint32_t cost(std::uint32_t pixel) const { return labels_[pixel]; }
    std::uint32_t source() const { return source_; }
    const PixelWindow& window() const { return window_; }

    static constexpr std::uint32_t unreached = std::numeric_limits<std::uint32_t>::max();

  private:
    // One of the eight ways out of a pixel: where it leads to, and which pixel keeps its cost.
    struct Way {
        int i, j;
        std::int64_t offset;       // from the pixel's index to the neighbour's
        std::int64_t step_offset;  // from step_directions * index to the cost
    };

    void expand(std::uint32_t pixel);
    void relax(std::uint32_t pixel, const Way& way);
    bool leads_into(const PixelWindow& window, Pixel p, const Way& way) const;
    std::uint32_t step_cost(std::uint32_t pixel, const Way& way) const {
        return costs_->steps[static_cast<std::size_t>(static_cast<std::int64_t>(step_directions * pixel) +
                                                      way.step_offset)];
    }
    template <class Visit>
    void for_each_in_window(const Visit& visit) const;

    const LivewireCosts* costs_;
    std::array<Way, 8> ways_;
    std::vector<std::uint32_t> labels_;
    BucketQueue queue_;
    PixelWindow window_;
    std::uint32_t source_ = 0;
    std::uint32_t least_label_ = 0;  // no pixel in the queue has a smaller label
    std::uint32_t escape_ = unreached;
};

}  // namespace anatomesh
