// The DICOM JSON model, as far as answers of DICOMweb services need it. Follows: PS3.18, annex F.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "anatomesh/base/result.h"
#include "anatomesh_io/contour/dicom_layout.h"

namespace anatomesh {

// What came instead of what was asked for, as in "text/html, which looks like a web page, perhaps for a login".
// Quotes nothing of the content, which may name a patient; its beginning suffices.
std::string what_came(std::string_view content_type, std::string_view content);

// Parses an answer; an empty one is null. Nested at most 64 deep. Error (file): E-NET-018 it is no JSON, with
// what it is instead.
Result<nlohmann::json> parse_dicom_json(std::string_view text, std::string_view content_type,
                                        const std::string& url);

// The values of an element as text, several joined by backslashes; of names the alphabetic form. Empty when
// there is none.
std::string json_text_of(const nlohmann::json& data_set, DicomTag tag);
// The first value of an element, when it is a whole number within 32 bits.
std::optional<std::uint32_t> json_number_of(const nlohmann::json& data_set, DicomTag tag);

}  // namespace anatomesh
