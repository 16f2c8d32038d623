// send_objects: DICOM files to a peer, by C-STORE or by DICOMweb (STOW-RS).
//
// Data sets go out byte for byte as they stand in their files. A file whose transfer syntax a DICOM peer does
// not take is sent in implicit VR little endian when it is not compressed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/network/object_store.h"
#include "anatomesh_io/network/peer.h"

namespace anatomesh {

// A file to send. Its identity was read from it.
struct OutgoingObject {
    std::string path;
    ObjectIdentity identity;
    std::string transfer_syntax;
    std::uint64_t data_set = 0;  // offset in the file; 0 and no meta header: the whole file
    std::uint64_t bytes = 0;     // of the file
    bool has_meta = false;
};

// The DICOM objects among files and folders (with the folders in them), in the order given, folders by name.
// What is no DICOM is passed over in folders (counted in `skipped`), and an error when it was named. Errors:
// E-INP-* files, E-DCL-* layouts, E-NET-006 no DICOM object, E-NET-007 an object does not say what it is.
Result<std::vector<OutgoingObject>> find_objects(const std::vector<std::string>& paths,
                                                 std::uint64_t& skipped, RunContext& context);

struct SentObject {
    std::uint32_t index = 0;  // into the objects given
    std::uint16_t status = 0;
    std::string reason;  // empty: it was stored
    bool is_stored() const { return reason.empty(); }
};

struct SendResult {
    std::vector<SentObject> objects;  // in the order given
    std::uint64_t stored = 0, bytes = 0;
};

// Sends all; an object that the peer refuses does not stop the others. Errors: those of Requestor and of
// HttpClient; E-NET-008 a file changed since it was found.
Result<SendResult> send_objects(const std::vector<OutgoingObject>& objects, const ConnectOptions& options,
                                const RunContext& context);

// The meaning of a status of C-STORE that is no success.
std::string text_of_status(std::uint16_t status);

}  // namespace anatomesh
