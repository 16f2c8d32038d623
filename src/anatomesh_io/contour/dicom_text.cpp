#include "anatomesh_io/contour/dicom_text.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcspchrs.h>
#include <dcmtk/oflog/oflog.h>

#include <mutex>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

DicomText dicom_text(std::string_view text, std::string_view character_set) {
    bool is_ascii = true;
    for (const char c : text) is_ascii = is_ascii && c != '\x1B' && static_cast<unsigned char>(c) < 0x80;
    if (is_ascii) return {std::string(text), true};
    static std::once_flag once;
    std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
    DcmSpecificCharacterSet converter;
    OFString converted;
    if (converter.selectCharacterSet(OFString(character_set.data(), character_set.size())).good() &&
        converter.convertString(text.data(), text.size(), converted).good())
        return {std::string(converted.c_str(), converted.size()), true};
    bool changed = false;
    return {valid_utf8(text, changed), false};
}

}  // namespace anatomesh
