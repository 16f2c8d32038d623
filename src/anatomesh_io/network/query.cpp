#include "anatomesh_io/network/query.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "anatomesh_io/contour/dicom_text.h"
#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/dicom_writer.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/network/dicom_json.h"
#include "anatomesh_io/network/http_client.h"
#include "anatomesh_io/network/object_store.h"

namespace anatomesh {

namespace {

using Answer = std::map<std::string, std::string>;

constexpr DicomTag level_tag{0x0008, 0x0052};
// Longer answers are refused, so that a hostile peer takes no memory. [bytes; >= 65536; B]
constexpr std::size_t most_answer_bytes = std::size_t{64} << 20;

const char* name_of(QueryLevel level) {
    switch (level) {
        case QueryLevel::study:
            return "STUDY";
        case QueryLevel::series:
            return "SERIES";
        case QueryLevel::instance:
            return "IMAGE";
    }
    return "";
}

// What is asked for at a level: what stands there, and the UIDs above.
std::vector<const QueryAttribute*> returned_at(QueryLevel level) {
    std::vector<const QueryAttribute*> wanted;
    for (const QueryAttribute& each : query_attributes()) {
        const bool is_uid_above =
            each.level < level && (each.tag == tags::study_instance || each.tag == tags::series_instance);
        if (each.level == level || is_uid_above) wanted.push_back(&each);
    }
    return wanted;
}

std::map<std::string, std::string> keys_of(const QueryOptions& options) {
    std::map<std::string, std::string> keys = options.match;
    if (!options.study.empty()) keys["StudyInstanceUID"] = options.study;
    if (!options.series.empty()) keys["SeriesInstanceUID"] = options.series;
    return keys;
}

Error query_error(const std::string& message, const ConnectOptions& connecting) {
    const Peer& peer = connecting.peer;
    return {ErrorKind::file,
            "E-NET-019",
            message,
            {"", "", "", "", peer.dicom ? peer.dicom->title + "@" + peer.dicom->host : peer.url},
            "check --level, --study, --series and --match; look into the peer's log"};
}

void sort_answers(QueryResult& result) {
    const auto key = [](const std::map<std::string, std::string>& answer) {
        std::string text;
        for (const char* name : {"StudyInstanceUID", "SeriesInstanceUID", "SOPInstanceUID"})
            if (const auto found = answer.find(name); found != answer.end()) text += found->second + "/";
        return text;
    };
    std::sort(result.answers.begin(), result.answers.end(),
              [&](const auto& a, const auto& b) { return key(a) < key(b); });
}

// What makes an answer none, so that no list is short without a word: it does not say which study, series or
// instance it is about, or it is about another than was asked for. Nothing: it is one.
std::optional<std::string> fault_of(const Answer& answer, const QueryOptions& options) {
    const char* keyword = options.level == QueryLevel::study    ? "StudyInstanceUID"
                          : options.level == QueryLevel::series ? "SeriesInstanceUID"
                                                                : "SOPInstanceUID";
    const auto own = answer.find(keyword);
    if (own == answer.end() || !is_uid(own->second))
        return std::string("an answer does not say its ") + keyword;
    const auto is_other = [&](const char* name, const std::string& asked) {
        const auto found = answer.find(name);
        return !asked.empty() && found != answer.end() && found->second != asked;
    };
    if (is_other("StudyInstanceUID", options.study))
        return "an answer is about another study than was asked for";
    if (is_other("SeriesInstanceUID", options.series))
        return "an answer is about another series than was asked for";
    return std::nullopt;
}

// A data set of an answer, as texts.
std::optional<Answer> answer_of(std::string_view data_set, const std::vector<const QueryAttribute*>& wanted) {
    const std::string file =
        meta_header({study_find_class, "1.2", implicit_little_syntax}) + std::string(data_set);
    const auto parsed = DataSet::parse(file, "answer");
    if (!parsed.ok()) return std::nullopt;
    const DicomItem root = parsed.value().root();
    const std::string_view characters = root.text(tags::character_set);
    Answer answer;
    for (const QueryAttribute* each : wanted) {
        const std::string text = dicom_text(root.text(each->tag), characters).text;
        if (!text.empty()) answer[each->keyword] = text;
    }
    return answer;
}

Result<QueryResult> query_dicom(const QueryOptions& options, const ConnectOptions& connecting,
                                const RunContext& context) {
    RequestorOptions asking{*connecting.peer.dicom, connecting.title, connecting.timeout_seconds, nullptr,
                            connecting.limits};
    std::optional<TlsContext> tls;
    if (connecting.use_tls) {
        ANATOMESH_TRY(tls, TlsContext::client(connecting.tls));
        asking.tls = &*tls;
    }
    ANATOMESH_TRY(
        Requestor requestor,
        Requestor::associate(asking, {{0, study_find_class, {implicit_little_syntax}, 0}}, {}, context));
    const auto wanted = returned_at(options.level);
    QueryResult result;
    std::optional<std::string> fault;
    std::size_t bytes = 0;
    const auto status =
        requestor.find(requestor.contexts()[0], query_identifier(options.level, keys_of(options), wanted),
                       [&](std::string_view data_set) {
                           result.is_cut = result.answers.size() == options.most_answers;
                           if (result.is_cut || bytes > most_answer_bytes) return false;
                           auto answer = answer_of(data_set, wanted);
                           fault = answer ? fault_of(*answer, options) : "an answer of the peer is malformed";
                           if (fault) return false;
                           for (const auto& [keyword, text] : *answer) bytes += text.size();
                           result.answers.push_back(std::move(*answer));
                           return bytes <= most_answer_bytes;
                       });
    // Also where the peer then does not end in good order.
    if (fault) return query_error(*fault, connecting);
    if (!status.ok()) return status.error();
    requestor.release();
    if (bytes > most_answer_bytes)
        return query_error("the answers are longer than 64 MiB: ask for less", connecting);
    if (status.value() != dimse::success && status.value() != dimse::cancelled)
        return query_error("the peer does not answer the query: " + text_of_query_status(status.value()),
                           connecting);
    sort_answers(result);
    return result;
}

std::string web_path(const QueryOptions& options, const std::vector<const QueryAttribute*>& wanted) {
    std::string path;
    if (!options.study.empty() && options.level > QueryLevel::study)
        path += "/studies/" + url_escaped(options.study);
    const bool in_series = !options.series.empty() && options.level == QueryLevel::instance;
    if (in_series && !options.study.empty()) path += "/series/" + url_escaped(options.series);
    path += options.level == QueryLevel::study    ? "/studies"
            : options.level == QueryLevel::series ? "/series"
                                                  : "/instances";
    path += "?limit=" + std::to_string(options.most_answers + 1);
    for (const auto& [keyword, value] : keys_of(options)) {
        const bool stands_in_path =
            !options.study.empty() && ((keyword == "StudyInstanceUID" && options.level > QueryLevel::study) ||
                                       (keyword == "SeriesInstanceUID" && in_series));
        if (!stands_in_path) path += "&" + keyword + "=" + url_escaped(value);
    }
    for (const QueryAttribute* each : wanted) path += std::string("&includefield=") + each->keyword;
    return path;
}

Result<QueryResult> query_web(const QueryOptions& options, const ConnectOptions& connecting,
                              const RunContext& context) {
    HttpClient client(connecting, context);
    const auto wanted = returned_at(options.level);
    std::string text;
    bool is_too_long = false;
    HttpClient::Receiver receiver{[](const HttpReply&) { return true; },
                                  [&](std::string_view bytes) {
                                      is_too_long = bytes.size() > most_answer_bytes - text.size();
                                      if (!is_too_long) text += bytes;
                                      return !is_too_long;
                                  }};
    ANATOMESH_TRY(const HttpReply reply,
                  client.get(web_path(options, wanted), "application/dicom+json", receiver));
    if (is_too_long) return query_error("the answer is longer than 64 MiB: ask for less", connecting);
    if (reply.status == 204) return QueryResult{};
    if (reply.status != 200) return client.refused(reply, "the query");
    ANATOMESH_TRY(const nlohmann::json parsed,
                  parse_dicom_json(text, reply.content_type, connecting.peer.url));
    QueryResult result;
    // Nothing found is an empty list: what is no list says nothing about what there is.
    const auto no_answer = [&](const std::string& what) {
        return Error{ErrorKind::file,
                     "E-NET-018",
                     what,
                     {"", "", "", "", connecting.peer.url},
                     "check that the URL is that of a DICOMweb service"};
    };
    if (!parsed.is_array())
        return no_answer("the answer is no list of DICOM JSON: what came is " +
                         what_came(reply.content_type, text));
    for (const nlohmann::json& item : parsed) {
        result.is_cut = result.answers.size() == options.most_answers;
        if (result.is_cut) break;
        Answer answer;
        for (const QueryAttribute* each : wanted) {
            const std::string value = json_text_of(item, each->tag);
            if (!value.empty()) answer[each->keyword] = value;
        }
        if (const auto fault = fault_of(answer, options)) return no_answer(*fault);
        result.answers.push_back(std::move(answer));
    }
    sort_answers(result);
    return result;
}

}  // namespace

const std::vector<QueryAttribute>& query_attributes() {
    using Level = QueryLevel;
    static const std::vector<QueryAttribute> all{
        {"StudyInstanceUID", tags::study_instance, "UI", Level::study, false},
        {"StudyDate", tags::study_date, "DA", Level::study, true},
        {"StudyTime", tags::study_time, "TM", Level::study, true},
        {"AccessionNumber", tags::accession_number, "SH", Level::study, true},
        {"PatientName", tags::patient_name, "PN", Level::study, true},
        {"PatientID", tags::patient_id, "LO", Level::study, true},
        {"PatientBirthDate", tags::patient_birth_date, "DA", Level::study, true},
        {"StudyID", tags::study_id, "SH", Level::study, true},
        {"StudyDescription", tags::study_description, "LO", Level::study, true},
        {"ModalitiesInStudy", {0x0008, 0x0061}, "CS", Level::study, false},
        {"NumberOfStudyRelatedSeries", {0x0020, 0x1206}, "IS", Level::study, false},
        {"NumberOfStudyRelatedInstances", {0x0020, 0x1208}, "IS", Level::study, false},
        {"SeriesInstanceUID", tags::series_instance, "UI", Level::series, false},
        {"Modality", tags::modality, "CS", Level::series, false},
        {"SeriesNumber", tags::series_number, "IS", Level::series, false},
        {"SeriesDescription", tags::series_description, "LO", Level::series, true},
        {"NumberOfSeriesRelatedInstances", {0x0020, 0x1209}, "IS", Level::series, false},
        {"SOPInstanceUID", tags::sop_instance, "UI", Level::instance, false},
        {"SOPClassUID", tags::sop_class, "UI", Level::instance, false},
        {"InstanceNumber", tags::instance_number, "IS", Level::instance, false}};
    return all;
}

const QueryAttribute* find_attribute(std::string_view keyword) {
    for (const QueryAttribute& each : query_attributes())
        if (keyword == each.keyword) return &each;
    return nullptr;
}

std::string query_identifier(QueryLevel level, const std::map<std::string, std::string>& keys,
                             const std::vector<const QueryAttribute*>& returned) {
    std::map<DicomTag, std::pair<const char*, std::string>> elements;
    for (const QueryAttribute* each : returned) elements[each->tag] = {each->vr, ""};
    bool is_ascii = true;
    for (const auto& [keyword, value] : keys) {
        const QueryAttribute* attribute = find_attribute(keyword);
        if (attribute) elements[attribute->tag] = {attribute->vr, value};
        for (const char c : value) is_ascii = is_ascii && static_cast<unsigned char>(c) < 0x80;
    }
    if (!is_ascii) elements[tags::character_set] = {"CS", "ISO_IR 192"};
    elements[level_tag] = {"CS", name_of(level)};
    DicomWriter writer(DicomWriter::Syntax::implicit_little);
    for (const auto& [tag, element] : elements) writer.element(tag, element.first, element.second);
    return writer.bytes();
}

Result<QueryResult> query_peer(const QueryOptions& options, const ConnectOptions& connecting,
                               const RunContext& context) {
    return connecting.peer.dicom ? query_dicom(options, connecting, context)
                                 : query_web(options, connecting, context);
}

std::string text_of_query_status(std::uint16_t status) {
    switch (status) {
        case 0xA700:
        case 0xA701:
        case 0xA702:
            return "it is out of resources";
        case 0xA801:
            return "it does not know the destination";
        case 0xA900:
            return "it does not understand the keys";
        case 0x0122:
            return "it does not support this service";
        case 0x0124:
            return "it does not allow it";
        case dimse::cancelled:
            return "it was cancelled";
        case 0xB000:
            return "some objects could not be sent";
        default: {
            constexpr char digits[] = "0123456789ABCDEF";
            std::string text = "it failed with status 0x";
            for (int shift = 12; shift >= 0; shift -= 4) text += digits[status >> shift & 15];
            return text;
        }
    }
}

}  // namespace anatomesh
