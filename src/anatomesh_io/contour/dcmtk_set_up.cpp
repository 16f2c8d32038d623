#include "anatomesh_io/contour/dcmtk_set_up.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/oflog/oflog.h>

#include <mutex>

namespace anatomesh {

void set_up_dcmtk() {
    static std::once_flag once;
    std::call_once(once, [] {
        OFLog::configure(OFLogger::OFF_LOG_LEVEL);
        dcmEnableUnknownVRConversion.set(OFTrue);
    });
}

bool is_sequence_tag(std::uint16_t group, std::uint16_t element) {
    const DcmDataDictionary& dictionary = dcmDataDict.rdlock();
    const DcmDictEntry* entry = dictionary.findEntry(DcmTagKey(group, element), nullptr);
    const bool answer = entry && entry->getEVR() == EVR_SQ;
    dcmDataDict.rdunlock();
    return answer;
}

}  // namespace anatomesh
