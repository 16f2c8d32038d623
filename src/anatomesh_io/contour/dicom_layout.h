// check_dicom_layout: walks the elements of a DICOM file before a parser that recurses and allocates by the
// file's own lengths is let near it.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "anatomesh/base/run_context.h"

namespace anatomesh {

struct DicomTag {
    std::uint16_t group = 0, element = 0;
    friend auto operator<=>(const DicomTag&, const DicomTag&) = default;
};
// "(3006,0039)".
std::string text_of(DicomTag tag);

enum class DicomEncoding : std::uint8_t { implicit_little, explicit_little, explicit_big };

struct DicomLimits {
    std::size_t sequence_depth = 128;                       // sequences within sequences. >= 1
    std::uint64_t inflated_bytes = std::uint64_t{4} << 30;  // of a deflated data set
    std::uint64_t inflated_ratio = 200;                     // inflated / deflated, beyond the first 16 MiB
};

struct DicomLayout {
    DicomEncoding encoding = DicomEncoding::explicit_little;
    std::string transfer_syntax;  // its UID
    std::size_t data_set = 0;     // offset of the data set in the file; unless deflated
    std::string inflated;         // the data set, when it was deflated
    bool has_meta = true;         // whether the file has a meta header
    bool is_guessed = false;      // no preamble; without a meta header the syntax is guessed
    bool has_meta_length = true;  // whether the meta header states its length, as it is
};

// What the walk meets, in the order of the file: the elements of the data set; `begin` and `end` of
// sequences, of their items (FFFE,E000) and of compressed pixel data, whose fragments are elements
// (FFFE,E000). Offsets are those in the file, or in the inflated data set. `vr` is empty where the file does
// not say.
class DicomEvents {
  public:
    virtual ~DicomEvents() = default;
    virtual void element(DicomTag tag, std::string_view vr, std::size_t offset, std::size_t length) = 0;
    virtual void begin(DicomTag tag, std::size_t offset) = 0;
    virtual void end() = 0;
};

// Whether `file` begins as DICOM files do: a preamble of 128 bytes, then DICM.
bool is_dicom(std::string_view file);

// Guarantees on success: every element ends within its item and within the file, every item and sequence of
// undefined length is delimited, every explicit VR is one of the standard's, nothing is nested deeper than
// the limit. `is_sequence(group, element)` says whether the dictionary holds the tag for a sequence (asked
// where the file does not say). A file without preamble or meta header is accepted when its first element is
// one of group 2 or 8. No recursion; memory O(depth), but for a deflated data set. `events` may be null.
// Errors: E-DCL-001 no DICOM file                      E-DCL-005 nested too deep (limit)
//         E-DCL-002 no, or unusable, meta header       E-DCL-006 a VR that there is not
//         E-DCL-003 a transfer syntax not known        E-DCL-007 items and delimiters out of place
//         E-DCL-004 an element longer than what holds it, or a file cut off: names tag and offset
//         E-DCL-008 the deflated data set is corrupt   E-DCL-009 it inflates beyond the limit (limit)
Result<DicomLayout> check_dicom_layout(std::string_view file, const std::string& file_name,
                                       const std::function<bool(std::uint16_t, std::uint16_t)>& is_sequence,
                                       const DicomLimits& limits = {}, DicomEvents* events = nullptr);

// Warns W-DCL-001 when the file has no preamble or no meta header, W-DCL-002 when the meta header does not
// state its length, or another one than it has.
void warn_of_guess(const DicomLayout& layout, const std::string& file_name, RunContext& context);

}  // namespace anatomesh
