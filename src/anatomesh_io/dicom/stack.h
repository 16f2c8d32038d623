// stack_frames: frames anywhere in space, sorted into a volume of parallel, equidistant slices.
//
// Slices are ordered by their position along the normal of the planes; numbers, names and slice thickness
// play no part in it. The step between slices is the one between the first and the last position, divided: so
// a gantry tilt comes out as a sheared volume with every corner where the positions say.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"
#include "anatomesh_io/dicom/object.h"

namespace anatomesh {

struct StackOptions {
    std::optional<std::uint64_t> volume;  // which of several volumes, from 0
    bool allow_gaps = false;              // interpolate linearly where slices are missing or unevenly spaced
    // Uneven steps, as a share of the step: up to `exact` they are rounding, up to `even` they are warned
    // about.
    double exact = 1e-4, even = 1e-2;
};

// A slice of the volume: frame `below`, or (1 - t) of it and t of `above`.
struct StackSlice {
    std::uint32_t below = 0, above = 0;  // indices into the frames
    double t = 0;                        // [0, 1)
};

struct Stack {
    ImageGeometry geometry;
    std::vector<StackSlice> slices;  // along the third axis; the volume is right-handed
    bool is_uneven = false;          // interpolated
};

// What the whole series says besides; for checks alone.
struct SeriesFacts {
    std::string name;  // for messages
    std::optional<double> gantry_tilt, spacing_between_slices, images_in_acquisition, slice_thickness;
};

// `labels` names the object of each frame by DicomFrame::object.
// Errors: E-DCM-011 frames of different size or pixel spacing; E-DCM-012 several orientations and no volume
// chosen; E-DCM-013 several volumes at the same places and none chosen; E-DCM-014 slices missing or uneven;
// E-DCM-015 no such volume; E-DCM-016 one slice alone, without any word on its thickness.
// Warnings: W-DCM-008 numbers contradict the positions; W-DCM-009 slightly uneven; W-DCM-010 a stated spacing
// that is not the one of the positions; W-DCM-011 a tilt that the positions do not have; W-DCM-012 an unusual
// extent; W-DCM-013 one slice, as thick as stated; W-DCM-014 gaps interpolated; W-DCM-015 fewer slices than
// stated.
// Requires: at least one frame. Complexity: n log n.
Result<Stack> stack_frames(const std::vector<DicomFrame>& frames, const std::vector<std::string>& labels,
                           const SeriesFacts& facts, const StackOptions& options, RunContext& context);

}  // namespace anatomesh
