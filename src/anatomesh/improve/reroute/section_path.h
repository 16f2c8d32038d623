// SectionPathSearch: ways over the section of a surface by a slice's plane, in the place of missed segments.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh/improve/core/surface_incidence.h"
#include "anatomesh/improve/reroute/contour_loop.h"
#include "anatomesh/improve/reroute/rerouted_contours.h"
#include "anatomesh/improve/reroute/surface_section.h"

namespace anatomesh {

// Where a way may leave the contour, or come back to it: from a missed segment outwards.
struct PathEnds {
    std::vector<LoopCorner> corners;
    std::vector<WayEnd> ends;  // at the price of what lies between them and the segment
    double length = 0;

    double at(std::uint32_t vertex) const {
        return std::find_if(corners.begin(), corners.end(),
                            [&](const LoopCorner& corner) { return corner.vertex == vertex; })
            ->at;
    }
};

// Over the section of the surface, and the places between which it replaces what is drawn.
struct SectionPath {
    std::vector<SectionPoint> points;
    double from = 0, to = 0;
    double farthest_mm = 0;

    std::vector<Vec3> places() const {
        std::vector<Vec3> all;
        for (const SectionPoint& point : points) all.push_back(point.place);
        return all;
    }
};

class SectionPathSearch {
  public:
    // Requires: all outlive this.
    SectionPathSearch(EditContext& edit, const RoutableContours& routable, ReroutedContours& contours)
        : edit_(edit), routable_(routable), contours_(contours), incidence_(edit) {}

    // Vertices of the contour that edges of its surface join to others, from missed segment n on: `step` is
    // +1 for those after it, -1 for those before it.
    PathEnds ends(const ReroutedContour& contour, std::size_t n, int step);

    // The shortest way from one of `here` to one of `there`, as SurfaceSection has it. It stays within
    // `most_mm` of what is drawn, and passes no other vertex of the slice's contours of the structure.
    std::optional<SectionPath> find(const ReroutedContour& contour, const PathEnds& here,
                                    const PathEnds& there);

  private:
    void add_row(std::uint32_t structure, const LoopCorner& x, const LoopCorner& y, bool both,
                 PathEnds& ends);
    void add(const LoopCorner& x, const LoopCorner& y, std::uint32_t v, PathEnds& ends) const;

    EditContext& edit_;
    const RoutableContours& routable_;
    ReroutedContours& contours_;
    SurfaceIncidence incidence_;
};

}  // namespace anatomesh
