// dicom_text: texts of DICOM files, without their padding and as UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace anatomesh {

struct DicomText {
    std::string text;      // valid UTF-8
    bool is_exact = true;  // false: not in the stated character set; what is no UTF-8 became U+FFFD
};

// `text` in the character sets that SpecificCharacterSet (0008,0005) states; empty means ASCII. Thread-safe.
DicomText dicom_text(std::string_view text, std::string_view character_set);

// Without the blanks and NULs at both ends.
std::string_view without_padding(std::string_view text);

}  // namespace anatomesh
