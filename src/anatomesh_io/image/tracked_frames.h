// Frames of a tracked sequence (PLUS, 3D Slicer: .igs.mha, .igs.nrrd, .seq.nrrd): ultrasound images each with
// its own pose, so that each is a slice somewhere in space and together they are no volume.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/trace/trace.h"
#include "anatomesh/image/image.h"
#include "anatomesh_io/image/read_image.h"

namespace anatomesh {

using KeyValues = std::vector<std::pair<std::string, std::string>>;

// Whether the keys of a header give poses to frames: Seq_Frame0000_ProbeToTrackerTransform and the like.
bool has_tracked_frames(const KeyValues& keys);

// The poses of `frames` images of `columns` x `rows` pixels. A pose is the product of the transforms of the
// frame (and of those given for all frames) that lead from Image to the target: options.pose_to, else the
// first there is a way to of Reference, Tracker, World. A pixel is its column and row, from 0, in the
// orientation that UltrasoundImageOrientation MF means; others are mirrored accordingly. Frames are left out
// whose pose or pixels have a status that is not OK, or whose transform is missing, and counted.
// Errors: E-TRK-001 no way from Image to the target, with the transforms there are; E-TRK-002 a transform
// that is not 16 finite numbers, or projective; E-TRK-003 a pose whose axes span no plane, are not at right
// angles, or that lies beyond 1e7 mm, or a transform between tools that is no rotation within 0.005;
// E-TRK-004 no frame has a pose and pixels; E-TRK-005 without options.tracked; E-TRK-006 an orientation that is not
// known; E-TRK-007 a transform that mirrors. Warnings: W-TRK-001 frames without a pose or pixels were left out;
// W-TRK-002 the axes of the target are not the patient's as far as the file tells (without options.frame).
Result<std::vector<FramePose>> read_poses(const KeyValues& keys, const std::array<std::uint64_t, 3>& sizes,
                                          const std::string& path, const ReadImageOptions& options,
                                          RunContext& context);

// A frame as an image of one slice. Its third step is 1 mm along the normal.
ImageGeometry geometry_of(const FramePose& pose, std::uint32_t columns, std::uint32_t rows);

// The slices of a label map traced each in the plane of its pose. labels.geometry: columns, rows, frames;
// poses name its frames. Of every structure of a frame the `largest` pieces are kept; 0: all. Errors and
// warnings: those of trace_contours(); E-TRC-001 when no frame has a contour. Requires: `grey` null or of the
// same geometry.
Result<TraceResult> trace_frames(const LabelMap& labels, const std::vector<FramePose>& poses, Frame frame,
                                 const GreyImage* grey, double threshold, std::uint32_t largest,
                                 const TraceOptions& options, RunContext& context);

}  // namespace anatomesh
