// choose_dicom: what of a folder a model is made of: contours, a segmentation, or images.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/contour/model/raw_contours.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/folder.h"

namespace anatomesh {

struct DicomChoice {
    DicomKind kind = DicomKind::image;   // image, rtstruct or segmentation
    std::vector<std::uint32_t> objects;  // the images of a series; one object of the other kinds
    std::vector<std::uint32_t>
        images;  // the series that contours or a segmentation refer to; empty when not there
};

// What is taken though the objects contradict each other.
struct ChooseOptions {
    bool ignore_frame_of_reference = false;  // --ignore-frame-of-reference
    bool ignore_patient = false;             // --ignore-patient
    bool match_by_geometry = false;          // --match-by-geometry
};

// Without `series` the RTSTRUCT or SEG of the folder, when there is one alone, else its image series, when
// there is one alone. With it (a UID, or the name that messages call it by) the objects of that series.
// Errors: E-DCM-028 no such series; E-DCM-029 several to choose from, with the list; E-DCM-031 nothing that
// could be used; E-DCM-032 contours and the series they refer to have different frames of reference;
// E-DCM-033 they are of different patients or studies; E-DCM-035 none of the images referred to is there, but
// others are (with match_by_geometry the choice has no images: match_images() finds them); the damage of a
// file. Warns W-DCM-018 when images that are referred to are not there, W-DCM-022 of what an option ignores.
Result<DicomChoice> choose_dicom(const DicomFolder& folder, const std::string& series, RunContext& context,
                                 const ChooseOptions& options = {});

// The image series of the folder on whose planes, and within whose pixels, every contour lies. Errors:
// E-DCM-036 none, or several.
Result<std::vector<std::uint32_t>> match_images(const RawContours& contours, const DicomFolder& folder);

// A line per series for messages: "1a2b3c4d: CT, 120 images of 512 x 512".
std::string describe_series(const DicomFolder& folder, const DicomSeries& series);

// What the user says of contours that do not fit their images.
struct AcceptContours {
    bool outside = false;        // --allow-outside
    bool unit_is_given = false;  // --unit: the coordinates are in mm by now
};

// Compares contours with the places of the images they refer to, and returns whether all lie on images. Errors: E-DCM-037 no contour lies within the
// images, unless accept.outside; E-DCM-038 the coordinates contradict the images, and would lie on them if they
// were cm or m and not mm, unless accept.unit_is_given. Warns W-DCM-019 of planes that lie on no image, W-DCM-020
// of contours outside all images, W-DCM-027 of contours that reach beyond the pixels of theirs. Where all contours lie on images, their unit is right, so that W-RTS-006 is taken
// back. Images whose places cannot be read are passed over.
Result<bool> check_against_images(const RawContours& contours, const DicomFolder& folder,
                                  const std::vector<std::uint32_t>& images, const AcceptContours& accept,
                                  RunContext& context);

// Warns W-DCM-024 of contours of an RTSTRUCT that lie elsewhere than on the image, or the frame, that each says it
// was drawn on, and W-DCM-025 of frames that the image does not have. Their coordinates count. Error: E-DCM-039 they
// are drawn on several frames of an image without places, so that their coordinates say nothing.
Status check_references(const DicomItem& rtstruct, const DicomFolder& folder,
                        const std::vector<std::uint32_t>& images, RunContext& context);

}  // namespace anatomesh
