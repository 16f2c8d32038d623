// DICOM RT Structure Set: contours as radiotherapy planning draws them.
#pragma once

#include <string_view>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

// Reads a file held in memory (any of the uncompressed transfer syntaxes, and the deflated one). A
// structure's number is the ROI number, the space of its contours that of its ReferencedFrameOfReferenceUID.
// Coordinates are DICOM's: LPS, mm. The contour types POINT, OPEN_PLANAR, OPEN_NONPLANAR, CLOSED_PLANAR and
// CLOSEDPLANAR_XOR are kept as they are; nothing is closed. Requires: an empty builder. Messages name the
// ROI, the contour (from 0, as in the file) and the point.
//
// Errors: E-RTS-001 DICOM that cannot be parsed
//         E-RTS-002 no structure set
//         E-RTS-003 an ROI without a usable number
//         E-RTS-004 two items for one ROI number
//         E-RTS-006 ContourData missing, or not 3 numbers a point
//         E-RTS-007 a coordinate that is no number
//         E-RTS-008 a contour type that there is not
//         E-RTS-009 no DICOM dictionary on this machine
//         E-RTS-011 slices so close that the coordinates are not in mm, unless the user gave their unit
// and those of dicom_layout.h (E-DCL-*).
//
// Warnings: W-RTS-001 contours of an ROI that is not declared
//           W-RTS-002 NumberOfContourPoints is not that of the data, which holds
//           W-RTS-003 no contour type: taken for CLOSED_PLANAR
//           W-RTS-004 a name in an unknown character set
//           W-RTS-005 a colour that is none
//           W-RTS-006 contours that are small and lie on close slices
//
// Complexity: linear; memory about four times the file.
// Thread-safe: the parser's global settings are made once, before its first use.
Status read_rtstruct(std::string_view file, RawBuilder& builder);

}  // namespace anatomesh
