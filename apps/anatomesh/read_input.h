// From an input file to prepared contours. Used by every verb that takes an image, a label map or a contour
// file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/measure/report.h"
#include "anatomesh/pipeline/prepare_contours.h"
#include "anatomesh_io/dicom/dicom_source.h"
#include "anatomesh_io/dicom/segmentation.h"
#include "anatomesh_io/file/detect.h"
#include "anatomesh_io/image/read_image.h"
#include "input_options.h"

namespace anatomesh {

// An input as it was read: an image, contours, or a segmentation.
struct OpenedInput {
    FileKind kind = FileKind::unknown;
    std::vector<InputReport> files;
    std::optional<LoadedImage> image;
    std::optional<RawContours> contours;
    std::optional<LoadedSegmentation> segmentation;
    std::optional<DicomSource> dicom_source;  // the study it is of, when it is DICOM
};

// Reads the input whole. Errors: those of the readers; E-CMD-012 a kind of file that is no image and no
// contours; usage E-CMD-008 an option that this kind of file has no use for. Warnings: W-CMD-003 an option
// that was not needed.
Result<OpenedInput> open_input(const InputOptions& options, RunContext& context);

// Whether this is a folder that is not one of contour files (.vtp).
bool is_dicom_folder(const std::string& path);

// The paths of files that were read.
std::vector<std::string> names_of(const std::vector<InputReport>& files);

// Contours as the verb wants them, and where they are from.
struct InputContours : PreparedContours {
    std::vector<InputReport> files;
    std::optional<DicomSource> dicom_source;
};

// prepare_contours() of what was opened, as options.prepare says; grey images need a threshold. The options
// that say how the input was read come before those of preparing. Errors: usage E-CMD-007 grey image without
// a threshold, E-CMD-008 an option that does not apply to this kind of input; those of the stages, and of
// `check` (prepare_contours.h).
Result<InputContours> contours_of(OpenedInput input, const InputOptions& options, RunContext& context,
                                  const ContoursCheck& check = {});

}  // namespace anatomesh
