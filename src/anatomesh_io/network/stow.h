// stow_objects: DICOM files to a DICOMweb service (STOW-RS). See send_objects.h.
#pragma once

#include <vector>

#include "anatomesh_io/network/send_objects.h"

namespace anatomesh {

// Several objects a request. Errors: those of HttpClient; E-NET-017 a request is refused as a whole;
// E-NET-008 a file changed; E-NET-018 the answer is not what it must be.
Result<SendResult> stow_objects(const std::vector<OutgoingObject>& objects, const ConnectOptions& options,
                                const RunContext& context);

}  // namespace anatomesh
