// place_frames: where the frames of an image object lie.
//
// An enhanced object says the place of each frame in its functional groups: in the patient's axes
// (PlanePositionSequence), or, of ultrasound volumes, in axes of the volume alone (PlanePositionVolumeSequence; DICOM
// PS3.3, C.7.6.16.2.21 and C.8.24.2). An object without such groups says the place of its first frame at most. The
// others follow along the normal of the first (row x column), by a rule of the format or of the user:
// - reconstructed nuclear medicine: SliceVector times SpacingBetweenSlices, whose sign counts (C.8.4.15);
// - GridFrameOffsetVector (C.8.8.3.2);
// - FrameOptions::step_mm.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/frame_groups.h"
#include "anatomesh_io/dicom/object.h"

namespace anatomesh {

// Whether the object says where its first frame lies, outside of functional groups.
bool states_first_place(const DicomItem& root);

// Fills in position, row and column of the frames, whose groups are parallel to them; they stay in the axes of the
// file, which `found` tells with the rule. `worst_orientation`: how far the worst orientation is from two unit
// vectors at right angles. Errors: E-DCM-002; E-DCM-004 a frame without position or orientation, also where others
// have their own; E-DCM-005, E-DCM-008, E-DCM-009; E-DCM-040 the place of the first frame alone, and no rule.
// Linear in the frames.
Status place_frames(const DataSet& set, const std::vector<FrameGroups>& groups, std::optional<double> step_mm,
                    FramesOfObject& found, double& worst_orientation);

// Turns x and y of every place: what was RAS is LPS then.
void turn_ras_to_lps(std::vector<DicomFrame>& frames);

}  // namespace anatomesh
