// check_dicom_layout: walks the elements of a DICOM file before a parser that recurses and allocates by the
// file's own lengths is let near it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "anatomesh/base/result.h"

namespace anatomesh {

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
};

// Whether `file` begins as DICOM files do: a preamble of 128 bytes, then DICM.
bool is_dicom(std::string_view file);

// Guarantees on success: every element ends within its item and within the file, every item and sequence of
// undefined length is delimited, every explicit VR is one of the standard's, nothing is nested deeper than
// the limit. `is_sequence(group, element)` says whether the dictionary holds the tag for a sequence (asked
// where the file does not say). No recursion; memory O(depth), but for a deflated data set. Errors: E-DCL-001
// no DICOM file                      E-DCL-005 nested too deep (limit)
//         E-DCL-002 no, or unusable, meta header       E-DCL-006 a VR that there is not
//         E-DCL-003 a transfer syntax not known        E-DCL-007 items and delimiters out of place
//         E-DCL-004 an element longer than what holds it, or a file cut off: names tag and offset
//         E-DCL-008 the deflated data set is corrupt   E-DCL-009 it inflates beyond the limit (limit)
Result<DicomLayout> check_dicom_layout(std::string_view file, const std::string& file_name,
                                       const std::function<bool(std::uint16_t, std::uint16_t)>& is_sequence,
                                       const DicomLimits& limits = {});

}  // namespace anatomesh
