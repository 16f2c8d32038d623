// JSON contour files: schemas/contours.schema.json.
//
//   {"format": "anatomesh-contours", "version": 1, "space": "LPS", "unit": "mm", "pixel_mm": 0.5,
//    "structures": [{"number": 1, "name": "liver", "color": [200, 80, 60]}],
//    "slices": [{"name": "z = 36", "plane": {"origin": [0, 0, 36], "normal": [0, 0, 1]},
//                "contours": [{"structure": 1, "kind": "closed", "points": [[x, y, z], ...]}]}]}
//
// space is LPS, RAS or unknown (as when absent). slice_thickness_mm is that of the source's slices. coverage is
// complete where a slice without a structure says that it is not there, else drawn (as when absent). exclusive is true
// where structures take no place of each other. kind is closed (as when absent), closed_xor, open or points.
// Left out may be: space, pixel_mm, slice_thickness_mm, coverage, exclusive, name, color, plane (which is then found from the points), kind. Members
// may come in any order. Text is UTF-8 without a byte order mark.
#pragma once

#include <string_view>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

// Requires: an empty builder. Messages name the path in the file: slices[3].contours[0].points[17].
// Errors: E-JSN-001 not JSON, or truncated      E-JSN-005 a member given twice
//         E-JSN-002 nested deeper than 64       E-JSN-006 a member that must be there is not
//         E-JSN-003 a value of another type     E-JSN-007 structures: a number twice, or one that there is
//         not E-JSN-004 a value that cannot be      E-JSN-008 a text longer than 1 MiB
// Warnings: W-JSN-001 a member of unknown name is ignored
// Complexity: linear; memory as the file and its points.
Status read_json_contours(std::string_view text, RawBuilder& builder);

}  // namespace anatomesh
