#include "anatomesh_io/network/fetch.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "anatomesh_io/network/dcmtk_door.h"
#include "anatomesh_io/network/dicom_json.h"
#include "anatomesh_io/network/http_client.h"
#include "anatomesh_io/network/multipart.h"
#include "anatomesh_io/network/query.h"
#include "anatomesh_io/network/receiver.h"

namespace anatomesh {

namespace {

// The class is asked for of so many series at most, one query each. [series; >= 1; B]
constexpr std::uint32_t most_series = 100;
// So many different reasons why objects did not come are kept for the message. [texts; >= 1; B]
constexpr std::size_t most_reasons = 10;

void count(FetchResult& result, const StoreOutcome& outcome) {
    switch (outcome.end) {
        case StoreEnd::stored:
            ++result.stored;
            result.bytes += outcome.bytes;
            break;
        case StoreEnd::there_already:
            ++result.there_already;
            break;
        case StoreEnd::unasked:
        case StoreEnd::refused: {
            ++(outcome.end == StoreEnd::unasked ? result.unasked : result.refused);
            if (result.refusals.size() < most_reasons)
                result.refusals.push_back({outcome.path, outcome.reason});
            const auto& reasons = result.reasons;
            const bool is_new = std::find(reasons.begin(), reasons.end(), outcome.reason) == reasons.end();
            if (is_new && reasons.size() < most_reasons) result.reasons.push_back(outcome.reason);
            break;
        }
    }
}

class FetchSink : public ObjectSink {
  public:
    FetchSink(ObjectStore& store, const ObjectLabel& label, FetchResult& result)
        : incoming_(store, label), result_(result) {
        incoming_.begin_data_set();
    }
    void write(std::string_view bytes) override { incoming_.write(bytes); }
    std::uint16_t finish() override {
        const StoreOutcome outcome = incoming_.finish();
        count(result_, outcome);
        return outcome.status;
    }

  private:
    ObjectStore::Incoming incoming_;
    FetchResult& result_;
};

QueryLevel level_of(const FetchOptions& options) {
    return !options.instance.empty() ? QueryLevel::instance
           : !options.series.empty() ? QueryLevel::series
                                     : QueryLevel::study;
}

std::string identifier_of(const FetchOptions& options) {
    std::map<std::string, std::string> keys{{"StudyInstanceUID", options.study}};
    if (!options.series.empty()) keys["SeriesInstanceUID"] = options.series;
    if (!options.instance.empty()) keys["SOPInstanceUID"] = options.instance;
    return query_identifier(level_of(options), keys, {});
}

// The classes of the objects of the study or series, as far as the peer says: a series has one as a rule.
std::vector<std::string> classes_there(const FetchOptions& options, const ConnectOptions& connecting,
                                       const RunContext& context) {
    QueryOptions query;
    query.level = QueryLevel::series;
    query.study = options.study;
    query.series = options.series;
    query.most_answers = most_series;
    std::vector<std::string> classes;
    const auto series = query_peer(query, connecting, context);
    if (!series.ok()) return classes;
    query.level = QueryLevel::instance;
    query.most_answers = 1;
    for (const auto& each : series.value().answers) {
        if (context.cancelled() || !RequestBudget(connecting.limits, {}).check_time().ok()) break;
        const auto uid = each.find("SeriesInstanceUID");
        if (uid == each.end() || !is_uid(uid->second)) continue;
        query.series = uid->second;
        const auto instance = query_peer(query, connecting, context);
        if (!instance.ok() || instance.value().answers.empty()) continue;
        const auto found = instance.value().answers[0].find("SOPClassUID");
        if (found != instance.value().answers[0].end() && is_storage_class(found->second) &&
            std::find(classes.begin(), classes.end(), found->second) == classes.end())
            classes.push_back(found->second);
    }
    return classes;
}

// What this side receives: of the classes that are there also compressed data sets, each in a context of its
// own, as the peer will hardly compress or decompress for us; besides the usual classes.
void add_storage_contexts(const std::vector<std::string>& there, std::vector<PresentationContext>& contexts,
                          std::vector<RoleSelection>& roles) {
    const auto add = [&](const std::string& sop_class, std::vector<std::string> syntaxes) {
        if (contexts.size() < most_presentation_contexts)
            contexts.push_back({0, sop_class, std::move(syntaxes), context_accepted});
    };
    const auto add_plain = [&](const std::string& sop_class) {
        std::vector<std::string> syntaxes{explicit_little_syntax, implicit_little_syntax};
        if (sop_class == rtstruct_class) std::swap(syntaxes[0], syntaxes[1]);
        add(sop_class, std::move(syntaxes));
    };
    for (const std::string& sop_class : there) add_plain(sop_class);
    for (const std::string& sop_class : there)
        for (const std::string& syntax : compressed_syntaxes()) add(sop_class, {syntax});
    for (const std::string& usual : usual_storage_classes(most_presentation_contexts))
        if (std::find(there.begin(), there.end(), usual) == there.end()) add_plain(usual);
    for (const PresentationContext& each : contexts) {
        const auto has_role = [&](const RoleSelection& role) {
            return role.sop_class == each.abstract_syntax;
        };
        if (each.abstract_syntax != study_get_class && std::none_of(roles.begin(), roles.end(), has_role))
            roles.push_back({each.abstract_syntax, false, true});
    }
}

Error fetch_error(const std::string& message, const ConnectOptions& connecting) {
    const Peer& peer = connecting.peer;
    return {ErrorKind::file,
            "E-NET-019",
            message,
            {"", "", "", "", peer.dicom ? peer.dicom->title + "@" + peer.dicom->host : peer.url},
            "check the UIDs and the peer's settings; look into the peer's log"};
}

Requestor::Progress progress_of(const RunContext& context) {
    return [&context](const Command& reply) {
        const double all = reply.remaining + reply.completed + reply.failed + reply.warned;
        if (all > 0) context.report("fetch", 1 - reply.remaining / all);
    };
}

// What a C-GET or C-MOVE came to.
Status settle(const Result<std::uint16_t>& status, const RetrieveCounts& counts,
              const ConnectOptions& connecting, FetchResult& result) {
    if (!status.ok()) return status.error();
    result.sent = static_cast<std::uint64_t>(counts.completed) + counts.warned;
    result.failed = counts.failed;
    const bool some_failed = status.value() == 0xB000;
    if (status.value() == dimse::success || some_failed) return Nothing{};
    return fetch_error("the peer does not send: " + text_of_query_status(status.value()), connecting);
}

Result<FetchResult> get_dicom(ObjectStore& store, const FetchOptions& options, const RequestorOptions& asking,
                              const ConnectOptions& connecting, const RunContext& context) {
    std::vector<PresentationContext> contexts{
        {0, study_get_class, {implicit_little_syntax}, context_accepted}};
    std::vector<RoleSelection> roles;
    add_storage_contexts(classes_there(options, connecting, context), contexts, roles);
    ANATOMESH_TRY(Requestor requestor, Requestor::associate(asking, contexts, roles, context));
    const PresentationContext* with = requestor.context_of(study_get_class);
    if (!with) {
        requestor.release();
        return fetch_error("the peer does not offer C-GET: use --move-to, or DICOMweb", connecting);
    }
    FetchResult result;
    RetrieveCounts counts;
    const auto open = [&](const ObjectLabel& label) -> std::unique_ptr<ObjectSink> {
        return std::make_unique<FetchSink>(store, label, result);
    };
    const auto status = requestor.get(*with, identifier_of(options), open, counts, progress_of(context));
    if (status.ok()) requestor.release();
    ANATOMESH_CHECK_STATUS(settle(status, counts, connecting, result));
    return result;
}

// A receiver in a thread of its own, for as long as a C-MOVE takes.
class Destination {
  public:
    Destination(ObjectStore& store, const FetchOptions& options, const ConnectOptions& connecting,
                FetchResult& result) {
        receiving_.title = options.move_to;
        receiving_.address = options.address;
        receiving_.port = options.port;
        receiving_.timeout_seconds = connecting.timeout_seconds;
        receiving_.allowed = {{"", addresses_of(connecting.peer.dicom->host)}};
        hooks_.listening = [this](std::uint16_t) { listens_ = true; };
        hooks_.log = [](const std::string&) {};
        hooks_.ended = [&result](const StoreOutcome& outcome) { count(result, outcome); };
        context_.cancel = &stop_;
        thread_ = std::thread([this, &store] {
            outcome_.emplace(receive_objects(store, receiving_, hooks_, context_));
            has_failed_ = !outcome_->ok();
            listens_ = true;
        });
        while (!listens_) std::this_thread::yield();
    }
    Destination(const Destination&) = delete;
    Destination& operator=(const Destination&) = delete;
    ~Destination() {
        stop_ = true;
        if (thread_.joinable()) thread_.join();
    }
    // Whether it could not listen.
    bool has_failed() const { return has_failed_; }
    // Ends it. The error, when it could not listen.
    Status end() {
        stop_ = true;
        thread_.join();
        if (!outcome_->ok()) return outcome_->error();
        return Nothing{};
    }

  private:
    ReceiverOptions receiving_;
    ReceiverHooks hooks_;
    RunContext context_;
    std::atomic<bool> stop_{false}, listens_{false}, has_failed_{false};
    std::optional<Result<ReceiverSummary>> outcome_;
    std::thread thread_;
};

Result<FetchResult> move_dicom(ObjectStore* store, const FetchOptions& options,
                               const RequestorOptions& asking, const ConnectOptions& connecting,
                               const RunContext& context) {
    FetchResult result, received;
    RetrieveCounts counts;
    ANATOMESH_TRY(
        Requestor requestor,
        Requestor::associate(asking, {{0, study_move_class, {implicit_little_syntax}, 0}}, {}, context));
    std::optional<Destination> destination;
    if (options.port != 0) destination.emplace(*store, options, connecting, received);
    if (destination && destination->has_failed()) return destination->end().error();
    const auto status = requestor.move(requestor.contexts()[0], identifier_of(options), options.move_to,
                                       counts, progress_of(context));
    if (status.ok()) requestor.release();
    if (destination) {
        ANATOMESH_CHECK_STATUS(destination->end());
        result = std::move(received);
    }
    ANATOMESH_CHECK_STATUS(settle(status, counts, connecting, result));
    return result;
}

// The parts of an answer of WADO-RS, each a DICOM file.
Result<FetchResult> get_web(ObjectStore& store, const FetchOptions& options, const ConnectOptions& connecting,
                            const RunContext& context) {
    HttpClient client(connecting, context);
    FetchResult result;
    std::unique_ptr<ObjectStore::Incoming> incoming;
    std::optional<MultipartReader> parts;
    bool is_malformed = false;
    RequestBudget budget(connecting.limits, connecting.peer.url);
    Status within_budget = Nothing{};
    MultipartReader::Sink sink;
    sink.begin = [&] {
        within_budget = budget.spend_answer();
        if (!within_budget.ok()) return false;
        incoming = std::make_unique<ObjectStore::Incoming>(store, ObjectLabel{});
        return true;
    };
    sink.data = [&](std::string_view bytes) {
        incoming->write(bytes);
        return true;
    };
    sink.end = [&] {
        ++result.sent;
        count(result, incoming->finish());
        incoming.reset();
        return true;
    };
    std::string beginning;  // of what is no multipart message
    HttpClient::Receiver receiver;
    receiver.begin = [&](const HttpReply& reply) {
        if (reply.status != 200) return true;
        if (const auto boundary = boundary_of(reply.content_type)) parts.emplace(*boundary, sink);
        return true;
    };
    receiver.data = [&](std::string_view bytes) {
        if (parts) is_malformed = !parts->feed(bytes);
        if (!parts) beginning = bytes;
        return parts && !is_malformed;
    };
    std::string path = "/studies/" + url_escaped(options.study);
    if (!options.series.empty()) path += "/series/" + url_escaped(options.series);
    if (!options.instance.empty()) path += "/instances/" + url_escaped(options.instance);
    ANATOMESH_TRY(
        const HttpReply reply,
        client.get(path, "multipart/related; type=\"application/dicom\"; transfer-syntax=*", receiver));
    ANATOMESH_CHECK_STATUS(within_budget);
    if (reply.status != 200 && reply.status != 404) return client.refused(reply, "the request");
    if (reply.status == 200 && (is_malformed || !parts || !parts->is_complete()))
        return Error{ErrorKind::file,
                     "E-NET-018",
                     parts ? "the parts of the answer are malformed, or it was cut off"
                           : "the answer is no multipart message of DICOM objects: what came is " +
                                 what_came(reply.content_type, beginning),
                     {"", "", "", "", connecting.peer.url},
                     parts ? "the objects that arrived are kept; run fetch again"
                           : "check that the URL is that of a DICOMweb service"};
    return result;
}

// Whether the peer says that it has nothing of what is asked for. Some call a retrieval of nothing a failure.
bool has_nothing(const FetchOptions& options, const ConnectOptions& connecting, const RunContext& context) {
    QueryOptions query;
    query.level = level_of(options);
    query.study = options.study;
    query.series = options.series;
    if (!options.instance.empty()) query.match["SOPInstanceUID"] = options.instance;
    query.most_answers = 1;
    const auto found = query_peer(query, connecting, context);
    return found.ok() && found.value().answers.empty();
}

}  // namespace

Result<FetchResult> fetch_objects(ObjectStore* store, const FetchOptions& options, const ConnectOptions& from,
                                  const RunContext& context) {
    ConnectOptions connecting = from;
    if (!connecting.limits.begun) connecting.limits.begun = Clock::now();
    assert(store || (!options.move_to.empty() && options.port == 0));
    if (store) store->take_only({options.study, options.series, options.instance});
    if (!connecting.peer.dicom) return get_web(*store, options, connecting, context);
    RequestorOptions asking{*connecting.peer.dicom, connecting.title, connecting.timeout_seconds, nullptr,
                            connecting.limits};
    std::optional<TlsContext> tls;
    if (connecting.use_tls) {
        ANATOMESH_TRY(tls, TlsContext::client(connecting.tls));
        asking.tls = &*tls;
    }
    auto result = options.move_to.empty() ? get_dicom(*store, options, asking, connecting, context)
                                          : move_dicom(store, options, asking, connecting, context);
    const bool is_refused = !result.ok() && result.error().code == "E-NET-019";
    if (is_refused && has_nothing(options, connecting, context)) return FetchResult{};
    return result;
}

}  // namespace anatomesh
