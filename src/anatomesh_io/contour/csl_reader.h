// CSL: contour lists of the cross-section literature.
//
//   CSLC
//   planes labels
//   id vertices components A B C D        one per plane, A x + B y + C z + D = 0
//   x y z                                 its vertices
//   count label i j k ...                 its components, by 0-based vertices; a hole is <count>h<parent>
//
// The label count of line 2 is not reliable and not used. A component's label is the structure's number; a
// hole belongs to its parent's structure. A CSL states no frame.
#pragma once

#include <string_view>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

// Requires: an empty builder. Messages name the line, the plane and the component.
// Errors: E-CSL-001 not a CSL                    E-CSL-005 a component names a vertex that there is not
//         E-CSL-002 truncated                    E-CSL-006 more after the last plane
//         E-CSL-003 not a number                 E-CSL-007 a hole without a parent that is an outer contour
//         E-CSL-004 a count that cannot be
// Warnings: W-CSL-001 vertices of no component   W-CSL-002 a hole with another label than its parent's
// Complexity: linear.
Status read_csl(std::string_view text, RawBuilder& builder);

}  // namespace anatomesh
