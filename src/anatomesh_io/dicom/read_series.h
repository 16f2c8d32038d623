// read_dicom_series: the images of a DICOM series as one volume.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/dicom/folder.h"
#include "anatomesh_io/dicom/stack.h"
#include "anatomesh_io/image/read_image.h"

namespace anatomesh {

struct ReadSeriesOptions {
    std::optional<std::uint64_t> volume;  // --volume N
    bool allow_gaps = false;              // --allow-gaps
    std::optional<ImageFrame> frame;      // --frame, of positions in axes that the files do not tell
    std::uint64_t max_voxels = std::uint64_t{1} << 34;
    InputLimits limits;
};

// Reads the objects (indices into the folder's, all images): CT, MR, PET and the like, one frame a file or
// many. Values are stored values x slope + intercept, slice by slice. The volume lies where the positions
// say; see stack.h. Compressed pixels are decoded in a process of their own. LoadedImage::inputs holds one
// entry: the folder, and the SHA-256 of the sums of the files, sorted. Errors: the image_error or damage of
// any object; those of stack.h and pixels.h; E-DCM-021 a frame that cannot be decoded; E-DCM-022 more pixels
// than the files can hold, or than the limit (limit); E-DCM-023 several frames of reference, or
// positions of the patient beside positions of a volume; E-DCM-024 two
// objects of one UID that differ; E-DCM-025 slices stored in different ways; E-DCM-026 a mosaic; E-DCM-027 a
// file that changed since it was listed. Warnings: those of the objects, of stack.h and pixels.h; W-DCM-003 a
// file that is there twice; W-DCM-004 slices without frame of reference; W-DCM-017 a localizer among the
// slices; W-DCM-026 positions in axes of the volume, that nobody ties to the patient. Requires: at least one object. Complexity: linear; memory 2 + 4 bytes a voxel and one file.
Result<LoadedImage> read_dicom_series(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                      const ReadSeriesOptions& options, RunContext& context);

// The planes of a series after removal of files that are there twice, as read_dicom_series() uses them,
// without its pixels. Same errors and warnings.
struct SeriesPlanes {
    std::vector<std::uint32_t> objects;  // those used; DicomFrame::object counts in these
    std::vector<std::string> labels;     // parallel to objects
    std::vector<DicomFrame> frames;
    SeriesFacts facts;
};
Result<SeriesPlanes> series_planes(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                   RunContext& context);

// One entry for many files.
InputHash hash_of(const DicomFolder& folder, const std::vector<std::uint32_t>& objects);

}  // namespace anatomesh
