// From an input file to kept contours: read, choose, trace or clean, simplify. Used by every verb that takes
// an image, a label map or a contour file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/contour_set.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh/measure/report.h"
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

// Kept contours, and all that the report says about how they came to be.
struct InputContours {
    ContourSet kept;
    std::vector<InputReport> files;
    std::vector<ContourReport> log;
    std::vector<std::pair<std::string, std::string>> options;  // as used, after defaults
    std::string hole_rule;
    std::uint64_t traced_points = 0;  // before simplification; of drawn contours, the points in the file
    std::uint32_t islands_left_out = 0;
    double epsilon_mm = 0;
    std::optional<DicomSource> dicom_source;
};

// Segmentations: chosen structures -> largest pieces -> kept slices -> traced and simplified.
// Images: threshold or labels -> chosen structures -> largest pieces -> kept slices -> traced and simplified.
// Contours: chosen structures -> cleaned -> kept slices -> simplified when --epsilon says so.
// Errors: usage E-CMD-005 no such structure, E-CMD-007 grey image without a threshold, E-CMD-008 an option
// that does not apply to this kind of input; those of the stages.
Result<InputContours> contours_of(OpenedInput input, const InputOptions& options, RunContext& context);

// Positions in `all` of the structures that the user named, ascending; all when `wanted` is empty. A text is
// a name first, else a number. Error: usage E-CMD-005, listing what there is.
Result<std::vector<std::uint32_t>> find_structures(const std::vector<Structure>& all,
                                                   const std::vector<std::string>& wanted,
                                                   const std::string& file);

// The same in the order in which they were named, each once; none when `wanted` is empty.
Result<std::vector<std::uint32_t>> find_in_order(const std::vector<Structure>& all,
                                                 const std::vector<std::string>& wanted,
                                                 const std::string& file);

// A structure's name where no other one has it, else its number: what find_structures() finds it by.
std::string unique_text(const std::vector<Structure>& all, std::uint32_t structure);

// The slices offset, offset + every, ... of a set of parallel slices. Requires: a kept set; every >= 1.
ContourSet every_nth_slice(const ContourSet& set, std::uint32_t every, std::uint32_t offset);

}  // namespace anatomesh
