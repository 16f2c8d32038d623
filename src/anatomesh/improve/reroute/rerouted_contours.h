// ReroutedContours: the contours with segments that no edges of their surface run along, as they are now.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/reroute/contour_loop.h"

namespace anatomesh {

// A contour, and what has become of it.
struct ReroutedContour {
    std::uint32_t number = 0;
    Contour contour;
    ContourLoop loop;
    bool is_rerouted = false;
    std::uint64_t segments = 0;  // that were missed and are not any more
    double farthest_mm = 0;
};

// Knows the vertices of all contours, as they are drawn and as they are now. A segment is missed where it is
// no chain of edges of its structure's surface.
class ReroutedContours {
  public:
    // Finds the contours with missed segments. Requires: both outlive this. Complexity: O(segments x stars).
    ReroutedContours(EditContext& edit, const RoutableContours& routable);

    std::size_t missed_at_first() const { return missed_at_first_; }
    std::size_t count_missed(const ReroutedContour& contour);
    bool is_missed(const ReroutedContour& contour, std::size_t n);
    // Whether all of it is edges of the surface where it is drawn: a way may lie on that.
    bool is_as_drawn(const ReroutedContour& contour);
    // Those with missed segments at first, by number.
    std::vector<ReroutedContour>& contours() { return contours_; }

    // Finds the vertices that the following ask for. O(n log n)
    void find_vertices();
    // Vertices of the slice's contours as they are and were; of one structure, or of all. Rising.
    std::span<const std::uint32_t> of_drawing(const Contour& contour) {
        return of_drawing_[drawing(contour)];
    }
    std::span<const std::uint32_t> of_slice(std::uint32_t slice) { return of_slice_[slice]; }
    bool is_drawn(std::uint32_t v) const;   // on a contour, as it is drawn
    bool is_on_way(std::uint32_t v) const;  // of a contour that was re-routed
    void note_way(const Contour& contour, const std::vector<std::uint32_t>& way);

    // Puts a stretch into a copy of the contour's loop. False if the contours of its slice are none of a kept
    // set then.
    bool replace(const ReroutedContour& contour, const LoopStretch& stretch, ContourLoop& loop) const;

  private:
    static std::uint64_t drawing(const Contour& contour) {
        return static_cast<std::uint64_t>(contour.slice) << 32 | contour.structure;
    }
    ReroutedContour as_drawn(std::uint32_t number) const;
    void note(const Contour& contour, std::uint32_t v);
    bool is_sound(const ReroutedContour& contour, const ContourLoop& changed) const;

    EditContext& edit_;
    const RoutableContours& routable_;
    SurfaceIncidence incidence_;
    std::size_t missed_at_first_ = 0;
    std::vector<ReroutedContour> contours_;
    std::map<std::uint64_t, std::vector<std::uint32_t>> of_drawing_;
    std::map<std::uint32_t, std::vector<std::uint32_t>> of_slice_;
    std::vector<std::uint32_t> drawn_, on_ways_;  // vertices; rising
};

}  // namespace anatomesh
