// DicomSource: the study that objects written here belong to.
//
// Privacy. Without keep_identity there is no name, number or date of the patient in it, and every UID is
// replaced by one made from it (the same for the same UID, so that objects of one study stay together).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh/image/image.h"
#include "anatomesh_io/dicom/folder.h"

namespace anatomesh {

struct DicomSource {
    struct Image {
        std::string sop_class, sop_instance;
        Vec3 position, normal;
        std::uint32_t frames = 1;
    };

    struct Origin {
        std::string study, series, sop_class, sop_instance;
        auto operator<=>(const Origin&) const = default;
    };

    std::string study, series, frame_of_reference;  // UIDs; empty: made from the content of what is written
    std::vector<Image> images;                      // of the series; may be empty
    std::optional<ImageGeometry> grid;              // of the series, when its axes are orthogonal
    std::vector<Origin> origins;                    // what a model is derived from, sorted
    bool keeps_identity = false;
    std::string software_version;  // of the program that writes; empty: not stated
    // Empty unless the identity is kept; in the source's character set.
    std::string character_set, patient_name, patient_id, birth_date, sex, study_date, study_time, study_id,
        accession, referring_physician;
};

// From the objects of a series (indices into the folder's); what is made is derived from them and from
// `also`. Reads one file again when the identity is kept. Errors: those of data_set.h and E-INP-*. Requires:
// at least one object.
Result<DicomSource> dicom_source(const DicomFolder& folder, const std::vector<std::uint32_t>& objects,
                                 bool keep_identity, const std::vector<std::uint32_t>& also = {});

// The UID that stands for another one where identities are not kept; empty for an empty one.
std::string replaced_uid(const std::string& uid);

}  // namespace anatomesh
