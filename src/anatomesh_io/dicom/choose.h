// choose_dicom: what of a folder a model is made of: contours, a segmentation, or images.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/raw_contours.h"
#include "anatomesh_io/dicom/folder.h"

namespace anatomesh {

struct DicomChoice {
    DicomKind kind = DicomKind::image;   // image, rtstruct or segmentation
    std::vector<std::uint32_t> objects;  // the images of a series; one object of the other kinds
    std::vector<std::uint32_t>
        images;  // the series that contours or a segmentation refer to; empty when not there
};

// Without `series` the RTSTRUCT or SEG of the folder, when there is one alone, else its image series, when
// there is one alone. With it (a UID, or the name that messages call it by) the objects of that series.
// Errors: E-DCM-028 no such series; E-DCM-029 several to choose from, with the list; E-DCM-031 nothing that
// could be used; E-DCM-032 contours and the series they refer to have different frames of reference;
// E-DCM-033 they are of different patients or studies; the damage of a file. Warns W-DCM-018 when images that
// are referred to are not there.
Result<DicomChoice> choose_dicom(const DicomFolder& folder, const std::string& series, RunContext& context);

// A line per series for messages: "1a2b3c4d: CT, 120 images of 512 x 512".
std::string describe_series(const DicomFolder& folder, const DicomSeries& series);

// Compares contours with the places of the images they refer to. Warns W-DCM-019 of planes that lie on no
// image, W-DCM-020 of contours outside all images. Images whose places cannot be read are passed over.
void check_against_images(const RawContours& contours, const DicomFolder& folder,
                          const std::vector<std::uint32_t>& images, RunContext& context);

}  // namespace anatomesh
