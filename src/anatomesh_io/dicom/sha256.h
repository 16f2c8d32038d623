// SHA-256 of texts, and UIDs made from it.
#pragma once

#include <string>
#include <string_view>

namespace anatomesh {

// Lower-case hexadecimal.
std::string sha256_text(std::string_view content);

// A DICOM UID that is the same for the same content: 2.25. and the decimal value of a name-based UUID
// (version 8: the first 128 bits of SHA-256, with version and variant set). At most 44 characters. Follows:
// DICOM PS3.5 B.2, RFC 9562.
std::string derived_uid(std::string_view content);

}  // namespace anatomesh
