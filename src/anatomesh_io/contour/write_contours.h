// write_contours: a kept contour set as a file that others read.
#pragma once

#include <string>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"

namespace anatomesh {

enum class ContourFormat : std::uint8_t {
    json,  // json_reader.h: everything
    vtp,   // vtp_contours.h: everything, as closed polylines that any VTK program shows
    csl    // csl_reader.h: planes, contours and the structures' numbers alone
};

// By the extension of the path: .json, .vtp, .csl, in upper or lower case.
// Error (usage): E-CIO-009, listing the extensions.
Result<ContourFormat> contour_format_of(const std::string& path);

// The file as bytes. Structures without contours are left out. Coordinates and planes are written so that
// they read back to the last bit, but for D of a CSL plane, which is right to two units in its last place.
// Reading what was written and writing it again gives the same bytes. Requires: a kept contour set, or one
// that obeys its invariants. Warnings: W-CIO-006 what the format cannot hold (names, colours and frame, in
// CSL).
std::string format_contours(const ContourSet& set, ContourFormat format, RunContext& context);

// Writes the file, whole or not at all. Errors: E-CIO-009, and those of atomic_file.h.
Status write_contours(const ContourSet& set, const std::string& path, RunContext& context);

}  // namespace anatomesh
