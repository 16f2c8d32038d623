// read_dicom_segmentation: a DICOM Segmentation (binary or fractional) or Label Map Segmentation as label
// maps.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

struct ReadSegmentationOptions {
    double threshold = 0.5;  // of fractional segments: this share of the maximum and more is inside. (0, 1]
    std::uint64_t max_voxels = std::uint64_t{1} << 34;
    // Of the first pixel of each image that the segmentation was made of: they say which planes there are
    // (segmentation_grid.h). Empty: the images are not there, or not parallel to the frames.
    std::vector<Vec3> image_positions = {};
};

// Segments may overlap; those of one layer do not. All layers have the geometry of the segmentation's own
// planes; planes that are not stored are empty.
struct LoadedSegmentation {
    std::vector<LabelMap> layers;
    std::string type;  // "BINARY", "FRACTIONAL", "LABELMAP"
    std::uint32_t frames = 0;
    bool known_axes = true;  // as in FramesOfObject; W-DCM-026 says when not
};

// Reads a file held in memory; `name` is for messages. A structure's number is the segment's number, or the
// value in a label map segmentation. Errors: those of data_set.h, object.h and pixels.h; E-SEG-001 no
// segmentation; E-SEG-002 a segment without usable number, or two of one number; E-SEG-003 frames that are
// not parallel; E-SEG-004 planes that lie on no common grid, or one of a thickness that nobody states; E-SEG-005 every segment is empty; E-SEG-006 a
// type of segmentation that is not read, or pixels that do not fit it; E-SEG-007 a frame without segment;
// E-SEG-008 one frame twice; E-SEG-009 larger than the limit; E-SEG-010 a frame that cannot be decoded.
// Warnings: W-SEG-001 a threshold was applied; W-SEG-002 a segment that is empty; W-SEG-003 frames of a
// segment that is not declared; W-SEG-004 planes missing between the frames of a segment, which are taken for
// empty; W-SEG-005 segments overlap; W-SEG-006 segment number 0, renumbered; W-SEG-008 nothing says how far apart
// planes are; W-SEG-007 frames two
// thicknesses apart were taken for neighbours. Complexity: linear in the pixels
// of the frames and the voxels of the layers, times the layers.
Result<LoadedSegmentation> read_dicom_segmentation(std::string_view file, const std::string& name,
                                                   const ReadSegmentationOptions& options,
                                                   RunContext& context);

}  // namespace anatomesh
