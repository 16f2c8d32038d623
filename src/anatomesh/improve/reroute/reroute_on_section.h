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

// Where a segment of drawn.routable is no chain of edges of its structure's surface, its contour is re-routed
// along the section of that surface by the slice's plane instead: the shortest way from a vertex that it has
// on the surface before that place to one after it, which stays off all other vertices of the slice's
// contours of the structure; the way and what is drawn there are nowhere further than `most_mm` from each
// other. Free vertices of the surface near the plane that the way passes move into it along an edge of the
// surface; where the way still crosses edges these get vertices, and the cells round them become two: the
// surface stays where it is but for those moves. Then `improve` works on the shapes. All of that is taken
// back if a cell changed inside has an angle whose sine is below `least_sine` - `last_sine` for the last ten
// segments that are left otherwise - or a ratio above the edit context's last bound - where contours force
// it, as the certificate has it, the bounds of recover_on_surface.h. `constraint_limited`: what
// drawn.constraint_limited looks at; vertices of segments that a way replaces, and of no other contour, are
// free again and limit nothing. Vertices of contours stay where they are, on the surface, though their
// contour may pass them by. Guarantees: all cells positive (checked exactly); surfaces keep their topology;
// vertices of the new contours are fixed, and so are their edges. Same result every time. Complexity:
// O(segments), and ms for each that is missed. Errors: none; what cannot be re-routed stays as it is drawn,
// and so does all where more than 1,000 segments are missed.
RerouteStats reroute_on_section(EditContext& edit, const DrawnSlices& drawn,
                                std::span<std::uint8_t> constraint_limited, double least_sine,
                                double last_sine, const ImproveCells& improve, const RunContext& context);

}  // namespace anatomesh
