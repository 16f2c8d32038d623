#include "anatomesh_io/network/dcmtk_door.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dcistrmb.h>
#include <dcmtk/dcmdata/dcostrmb.h>
#include <dcmtk/dcmdata/dctk.h>

#include <algorithm>
#include <vector>

#include "anatomesh_io/contour/dcmtk_set_up.h"
#include "anatomesh_io/network/acceptor.h"

namespace anatomesh {

bool is_storage_class(std::string_view sop_class) {
    for (int i = 0; i < numberOfDcmAllStorageSOPClassUIDs; ++i)
        if (sop_class == dcmAllStorageSOPClassUIDs[i]) return true;
    return false;
}

std::vector<std::string> usual_storage_classes(std::size_t most) {
    // DCMTK's list for one association leaves out what this program writes.
    std::vector<std::string> classes{UID_EncapsulatedSTLStorage, UID_EncapsulatedOBJStorage};
    for (int i = 0; i < numberOfDcmLongSCUStorageSOPClassUIDs && classes.size() < most; ++i)
        if (std::find(classes.begin(), classes.end(), dcmLongSCUStorageSOPClassUIDs[i]) == classes.end())
            classes.emplace_back(dcmLongSCUStorageSOPClassUIDs[i]);
    return classes;
}

std::optional<std::string> implicit_data_set(std::string_view file) {
    set_up_dcmtk();
    DcmInputBufferStream input;
    input.setBuffer(file.data(), static_cast<offile_off_t>(file.size()));
    input.setEos();
    DcmFileFormat object;
    object.transferInit();
    const bool is_read = object.read(input).good();
    object.transferEnd();
    DcmDataset* data = object.getDataset();
    if (!is_read || !data->canWriteXfer(EXS_LittleEndianImplicit, data->getOriginalXfer()))
        return std::nullopt;
    std::string out;
    std::vector<char> chunk(std::size_t{1} << 20);
    DcmOutputBufferStream output(chunk.data(), static_cast<offile_off_t>(chunk.size()));
    data->transferInit();
    OFCondition written = EC_StreamNotifyClient;
    while (written == EC_StreamNotifyClient) {
        written = data->write(output, EXS_LittleEndianImplicit, EET_ExplicitLength, nullptr);
        void* bytes = nullptr;
        offile_off_t length = 0;
        output.flushBuffer(bytes, length);
        out.append(static_cast<const char*>(bytes), static_cast<std::size_t>(length));
    }
    data->transferEnd();
    if (written.bad()) return std::nullopt;
    return out;
}

}  // namespace anatomesh
