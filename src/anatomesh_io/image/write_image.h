// write_image: images and label maps as NRRD or NIfTI files.
//
// NRRD (.nrrd): gzip; space left-posterior-superior; structures of a label map with names, numbers and
// colours as 3D Slicer writes its segmentations. NIfTI-1 (.nii, .nii.gz): sform alone (qform_code 0), RAS; no
// names. Both little endian; the same bytes for the same image. What was written reads back with the same
// voxels; positions to the last bit in NRRD, in single precision in NIfTI.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "anatomesh/base/result.h"
#include "anatomesh/image/image.h"

namespace anatomesh {

enum class ImageFormat : std::uint8_t { nrrd, nifti, nifti_gzip };

// By the extension of the path: .nrrd, .nii, .nii.gz, in upper or lower case.
// Error (usage): E-IMG-016, listing the extensions.
Result<ImageFormat> image_format_of(const std::string& path);

// `made_by` says how an image came to be, on one line: the description of a NIfTI image (its first 79 bytes),
// the key anatomesh of a NRRD one. It holds no name of a file, so that equal images are equal files.
//
// The file as bytes. Values are 32-bit floats. Requires: voxels.size() == geometry.voxel_count().
// Error (limit): E-IMG-017 an axis longer than NIfTI-1 can hold (32767).
Result<std::string> format_image(const ImageGeometry& geometry, std::span<const float> voxels,
                                 ImageFormat format, const std::string& made_by = {});

// The file as bytes. Every voxel holds the number of its structure, 0 outside, in 8 or 16 bits without sign,
// or 32 with. Error (limit): E-IMG-017 likewise.
Result<std::string> format_label_map(const LabelMap& labels, ImageFormat format,
                                     const std::string& made_by = {});

}  // namespace anatomesh
