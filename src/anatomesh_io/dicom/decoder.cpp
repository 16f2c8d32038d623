#include "anatomesh_io/dicom/decoder.h"

#include <fcntl.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

#include "anatomesh_io/dicom/jpeg2000_stream.h"

namespace anatomesh {

namespace {

// Words of libjpeg's warnings of damaged data. It goes on after them, with other pixels. [text; D libjpeg]
constexpr std::array damage_words{"Corrupt JPEG data", "Premature end", "Inconsistent progression",
                                  "Invalid SOS parameters"};
// Messages beyond it are left out. [bytes; >= 1; B]
constexpr std::size_t most_messages = 4096;

// What the decoders print while it exists: they tell of damage in no other way. One at a time in a process.
class PrintedMessages {
  public:
    PrintedMessages()
        : file_(::memfd_create("messages", MFD_CLOEXEC)),
          before_(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0)) {
        if (is_kept()) ::dup2(file_, STDERR_FILENO);
    }
    PrintedMessages(const PrintedMessages&) = delete;
    PrintedMessages& operator=(const PrintedMessages&) = delete;
    ~PrintedMessages() {
        std::fflush(stderr);
        if (is_kept()) ::dup2(before_, STDERR_FILENO);
        if (file_ >= 0) ::close(file_);
        if (before_ >= 0) ::close(before_);
    }

    bool is_kept() const { return file_ >= 0 && before_ >= 0; }

    // The first line that tells of damage; empty where none does.
    std::string damage() const {
        std::fflush(stderr);
        std::string text(most_messages, '\0');
        const ssize_t size = ::pread(file_, text.data(), text.size(), 0);
        text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
        std::size_t first = std::string::npos;
        for (const char* words : damage_words) first = std::min(first, text.find(words));
        return first == std::string::npos ? "" : text.substr(first, text.find('\n', first) - first);
    }

  private:
    int file_, before_;
};

bool is_jpeg2000(const std::string& transfer_syntax) {
    return transfer_syntax == "1.2.840.10008.1.2.4.90" || transfer_syntax == "1.2.840.10008.1.2.4.91";
}

std::string lost_bytes(const std::vector<std::string_view>& fragments) {
    std::string whole;
    for (const std::string_view bytes : fragments) whole += bytes;
    const auto lost = zeroed_stretch(whole);
    return lost ? "a stretch of " + std::to_string(*lost) +
                      " bytes of the compressed data was lost: all are zero"
                : std::string();
}

}  // namespace

bool can_decode(const std::string& transfer_syntax) {
    constexpr std::array known{"1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57",
                               "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81",
                               "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91", "1.2.840.10008.1.2.5"};
    return std::find(known.begin(), known.end(), transfer_syntax) != known.end();
}

std::string decode_frame(const std::vector<std::string_view>& fragments, const std::string& transfer_syntax,
                         const PixelFormat& format, std::span<std::byte> out) {
    if (is_jpeg2000(transfer_syntax)) {
        std::string lost = lost_bytes(fragments);
        if (!lost.empty()) return lost;
    }
    const PrintedMessages messages;
    if (!messages.is_kept()) return "the messages of the decoder cannot be read";
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
    const std::string damage = messages.damage();
    if (!damage.empty()) return "the decoder says: " + damage;
    if (image.GetDimension(0) != format.columns || image.GetDimension(1) != format.rows ||
        image.GetBufferLength() != out.size())
        return "the frame has another size than the header states";
    std::memcpy(out.data(), values.data(), out.size());
    return {};
}

}  // namespace anatomesh
