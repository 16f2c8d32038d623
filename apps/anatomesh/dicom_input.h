// DICOM inputs: a folder with studies in it, or one image or segmentation object.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "anatomesh_io/dicom/dicom_source.h"
#include "read_input.h"

namespace anatomesh {

// Opens what the options choose of a folder or file: an image series, the contours of an RTSTRUCT, or a SEG.
// Errors and warnings: those of the DICOM readers.
Result<OpenedInput> open_dicom(const InputOptions& options, RunContext& context);

// Of an RTSTRUCT that is given alone: warns W-DCM-018 when it refers to images.
void warn_of_absent_images(const InputOptions& options, RunContext& context);

// The study that DICOM outputs belong to: that of the input, if it has one.
Result<DicomSource> output_source(const InputOptions& options, const std::optional<DicomSource>& source,
                                  RunContext& context);

// What is in a folder, without reading images: its series, and what is no DICOM. Error: E-CMD-012 no DICOM
// objects.
Result<nlohmann::ordered_json> folder_json(const InputOptions& options, RunContext& context);
std::string folder_text(const nlohmann::ordered_json& folder);

}  // namespace anatomesh
