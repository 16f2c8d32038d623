// reroute_on_section: contours whose segments no edges of the surface run along follow it in their slices.
#pragma once

#include <cstdint>
#include <vector>

#include "anatomesh/improve/core/edit_context.h"
#include "anatomesh/improve/surgery/recover_on_surface.h"

namespace anatomesh {

struct RerouteStats {
    std::uint64_t missed = 0;            // segments that were no chains of edges of the surface
    std::vector<RoutedContour> routed;   // contours that were re-routed along it, by index
    std::vector<std::uint32_t> changed;  // cells that were made or reshaped, some of which may be gone
};

// A segment of drawn.routable is missed if it is no chain of edges of its structure's surface. Its contour is
// re-routed along the section of that surface by the slice's plane instead:
// 1. The shortest way is sought from a vertex that the contour has on the surface before that place to one
//    after it (section_path.h). It stays off all other vertices of the slice's contours of the structure; it
//    and what is drawn there are nowhere further than `most_mm` from each other.
// 2. Free vertices of the surface near the plane that the way passes move into it along an edge of the
//    surface.
// 3. Where the way still crosses edges these get vertices, and the cells round them become two. So the
//    surface stays where it is but for those moves.
// 4. `improve` works on the shapes.
// All of that is undone if a changed cell inside has an angle whose sine is below `least_sine`, or a ratio
// above the edit context's last bound. For the last ten segments that are left otherwise, `last_sine`
// counts; where contours force a cell, as the certificate has it, the bounds of quality_gate.h do.
//
// `constraint_limited`: what drawn.constraint_limited looks at. Vertices of segments that a way replaces,
// and of no other contour, are free again and limit nothing. Vertices of contours stay where they are, on
// the surface, though their contour may pass them by. Guarantees: all cells positive (checked exactly);
// surfaces keep their topology; vertices of the new contours are fixed, and so are their edges. Same result
// every time. Complexity: O(segments), and ms for each that is missed. Errors: none; what cannot be
// re-routed stays as it is drawn, and so does all where more than 1,000 segments are missed.
RerouteStats reroute_on_section(EditContext& edit, const DrawnSlices& drawn,
                                std::span<std::uint8_t> constraint_limited, double least_sine,
                                double last_sine, const ImproveCells& improve, const RunContext& context);

}  // namespace anatomesh
