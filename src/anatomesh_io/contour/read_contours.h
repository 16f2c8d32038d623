// read_contours: contours out of a file, whatever its format.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh_io/contour/contour_limits.h"
#include "anatomesh_io/file/input_file.h"

namespace anatomesh {

enum class FrameChoice : std::uint8_t {
    as_stated,  // of a file that states none the numbers are kept, with frame unknown and a warning
    lps,        // a file that states none is in LPS
    ras         // a file that states none is in RAS: x and y are turned
};

struct ReadContoursOptions {
    FrameChoice frame = FrameChoice::as_stated;
    std::optional<std::uint64_t> time_frame{};  // of guide points
    // What one unit of the file's coordinates is, where the user says it: 1, 10 or 1000. Nothing: they are mm, and
    // an RTSTRUCT that cannot be in mm is refused. mm.
    std::optional<double> unit_mm{};
    ContourLimits limits{};
    InputLimits file_limits{};
};

// Reads our JSON, CSL, VTK XML polydata (.vtp; also a folder of them, one structure each), cardiac guide
// points and DICOM RTSTRUCT, told apart by their content. Nothing is repaired, snapped or closed here:
// clean_contours() does that. Guarantees: structures sorted by number, each with a contour; finite
// coordinates within the limits; frame lps unless the file states none and none was asked for;
// coordinates in mm. Errors: those
// of the formats' readers (E-CSL-*, E-GPT-*, E-JSN-*, E-VTP-*, E-RTS-*, E-DCL-*), of raw_builder.h (E-CIO-001
// to -007), of the file (E-INP-*), and E-CIO-008 when the content is of no known format.
Result<RawContours> read_contours(const std::string& path, const ReadContoursOptions& options,
                                  RunContext& context);

}  // namespace anatomesh
