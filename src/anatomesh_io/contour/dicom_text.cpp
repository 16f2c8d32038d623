#include "anatomesh_io/contour/dicom_text.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcspchrs.h>

#include "anatomesh_io/contour/dcmtk_set_up.h"
#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

DicomText dicom_text(std::string_view text, std::string_view character_set) {
    bool is_ascii = true;
    for (const char c : text) is_ascii = is_ascii && c != '\x1B' && static_cast<unsigned char>(c) < 0x80;
    if (is_ascii) return {std::string(text), true};
    set_up_dcmtk();
    DcmSpecificCharacterSet converter;
    OFString converted;
    if (converter.selectCharacterSet(OFString(character_set.data(), character_set.size())).good() &&
        converter.convertString(text.data(), text.size(), converted).good())
        return {std::string(converted.c_str(), converted.size()), true};
    bool changed = false;
    return {valid_utf8(text, changed), false};
}

std::string_view without_padding(std::string_view text) {
    const auto is_pad = [](char c) { return c == ' ' || c == '\0'; };
    while (!text.empty() && is_pad(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_pad(text.back())) text.remove_suffix(1);
    return text;
}

}  // namespace anatomesh
