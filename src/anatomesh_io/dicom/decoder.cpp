#include "anatomesh_io/dicom/decoder.h"

#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace anatomesh {

bool can_decode(const std::string& transfer_syntax) {
    constexpr std::array known{"1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57",
                               "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81",
                               "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91", "1.2.840.10008.1.2.5"};
    return std::find(known.begin(), known.end(), transfer_syntax) != known.end();
}

std::string decode_frame(const std::vector<std::string_view>& fragments, const std::string& transfer_syntax,
                         const PixelFormat& format, std::span<std::byte> out) {
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    auto sequence = gdcm::SequenceOfFragments::New();
    for (const std::string_view bytes : fragments) {
        gdcm::Fragment fragment;
        fragment.SetByteValue(bytes.data(), gdcm::VL(static_cast<std::uint32_t>(bytes.size())));
        sequence->AddFragment(fragment);
    }
    gdcm::DataElement data(gdcm::Tag(0x7fe0, 0x0010));
    data.SetVR(gdcm::VR::OB);
    data.SetValue(*sequence);

    gdcm::Image image;
    image.SetNumberOfDimensions(2);
    image.SetDimension(0, format.columns);
    image.SetDimension(1, format.rows);
    gdcm::PixelFormat pixel(1, static_cast<unsigned short>(format.bits_allocated),
                            static_cast<unsigned short>(format.bits_stored),
                            static_cast<unsigned short>(format.high_bit), format.is_signed ? 1 : 0);
    image.SetPixelFormat(pixel);
    image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
    image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(transfer_syntax.c_str()));
    image.SetDataElement(data);

    if (image.GetBufferLength() != out.size()) return "the frame has another size than the header states";
    std::vector<char> values(out.size());
    if (!image.GetBuffer(values.data())) return "the compressed data is damaged";
    if (image.GetDimension(0) != format.columns || image.GetDimension(1) != format.rows ||
        image.GetBufferLength() != out.size())
        return "the frame has another size than the header states";
    std::memcpy(out.data(), values.data(), out.size());
    return {};
}

}  // namespace anatomesh
