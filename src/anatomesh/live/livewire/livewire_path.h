// LivewirePath: a boundary drawn with several anchors, each joined to the one before along edges or straight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "anatomesh/live/livewire/livewire.h"

namespace anatomesh {

enum class LivewireSegment : std::uint8_t { along_edges, straight };

// What was clicked, and the lines between the clicks. Lines are frozen as they were shown; only the last anchor has a
// tree of paths, so memory does not grow with the anchors but by their lines.
// Requires: the costs outlive the object, or its next set_costs().
class LivewirePath {
  public:
    explicit LivewirePath(const LivewireCosts& costs, const LivewireOptions& options = {});

    // Adds an anchor at the pixel nearest to a point (mm in the picture's plane), freezes the line to it, and returns the
    // pixel. An anchor may lie on an earlier one. Errors: input E-LIV-106 the point is not finite; nothing changes then.
    // Complexity: that of Livewire::line_to and set_anchor.
    Result<NearestPixel> add_anchor(Vec2 point, LivewireSegment segment = LivewireSegment::along_edges);

    // Takes the last anchor back, with the line to it. line_to() then starts at the anchor before, at once. Returns false
    // if there is no anchor. Complexity: that of Livewire::set_anchor.
    bool step_back();

    // Returns the line from the last anchor to the pointer, not frozen. Errors: input E-LIV-106 the pointer is not finite.
    // Requires: an anchor.
    Result<LivewireLine> line_to(Vec2 pointer, LivewireSegment segment = LivewireSegment::along_edges);

    // Returns the frozen lines and the line from the last anchor back to the first, as one ring: no point comes twice in
    // a row, and the first is not repeated. The ring may touch or cross itself. The path stays as it is.
    // Errors: input E-LIV-107 the ring has fewer than three points.
    Result<std::vector<Vec2>> ring(LivewireSegment segment = LivewireSegment::along_edges);

    // Returns the frozen lines as one, from the first anchor to the last; no point comes twice in a row. O(length)
    std::vector<Vec2> frozen() const;
    // The pixel centres of the anchors, in mm.
    const std::vector<Vec2>& anchors() const { return anchors_; }

    // Leads lines by other costs from now on, such as trained ones. Frozen lines stay.
    // Requires: the same grid. O(pixels)
    void set_costs(const LivewireCosts& costs);

  private:
    LivewireOptions options_;
    Livewire wire_;              // its anchor is the last one
    std::vector<Vec2> anchors_;  // mm
    std::vector<std::vector<Vec2>>
        lines_;  // parallel: from the anchor before; of the first anchor itself alone
};

}  // namespace anatomesh
