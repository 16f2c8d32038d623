// query_peer: what studies, series or instances an archive has: C-FIND in the study root model, or QIDO-RS.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "anatomesh/base/run_context.h"
#include "anatomesh_io/contour/dicom_layout.h"
#include "anatomesh_io/network/peer.h"

namespace anatomesh {

enum class QueryLevel : std::uint8_t { study, series, instance };

// An attribute that can be asked for and matched.
struct QueryAttribute {
    const char* keyword;
    DicomTag tag;
    const char* vr;
    QueryLevel level;     // at which it stands
    bool is_identifying;  // may hold the name, an id or a date of a patient, or free text with them in it
};
const std::vector<QueryAttribute>& query_attributes();
// Nothing of that name: null.
const QueryAttribute* find_attribute(std::string_view keyword);

struct QueryOptions {
    QueryLevel level = QueryLevel::study;
    std::string study, series;  // UIDs that the level lies under; empty: any, where the peer lets
    std::map<std::string, std::string> match;  // keyword to value; wildcards and ranges as DICOM has them
    std::uint32_t most_answers = 1000;
};

struct QueryResult {
    std::vector<std::map<std::string, std::string>> answers;  // keyword to text, UTF-8; absent: not said
    bool is_cut = false;                                      // there were more answers
};

// Answers in the order of their UIDs. Each says the UID of its level, and lies under the study and series that
// were asked for. Errors: those of Requestor and of HttpClient; E-NET-018 what a service gives is no list of
// DICOM JSON, or an answer in it is none; E-NET-019 the peer refuses the query or cannot answer it.
Result<QueryResult> query_peer(const QueryOptions& options, const ConnectOptions& connecting,
                               const RunContext& context);

// A C-FIND, C-GET or C-MOVE identifier, implicit VR little endian: the level, the keys, and what to return.
std::string query_identifier(QueryLevel level, const std::map<std::string, std::string>& keys,
                             const std::vector<const QueryAttribute*>& returned);

// Study root: the classes of the services.
inline constexpr const char* study_find_class = "1.2.840.10008.5.1.4.1.2.2.1";
inline constexpr const char* study_move_class = "1.2.840.10008.5.1.4.1.2.2.2";
inline constexpr const char* study_get_class = "1.2.840.10008.5.1.4.1.2.2.3";

// The meaning of a failure status of a query or retrieval.
std::string text_of_query_status(std::uint16_t status);

}  // namespace anatomesh
