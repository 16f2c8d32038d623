// anatomesh fetch: a study, series or instance from an archive.
#include "anatomesh_io/network/fetch.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "anatomesh/base/plural.h"
#include "answer.h"
#include "help_text.h"
#include "network_options.h"
#include "option_values.h"
#include "progress_bar.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct FetchVerbOptions {
    NetworkOptions network;
    FetchOptions fetch;
    std::string folder;
    std::uint32_t port = 0;
    double quota_mb = 0;  // 0: none
    bool address_given = false;
};

Status check_uids(const FetchOptions& fetch) {
    for (const auto& [option, uid] : {std::pair{"--study", fetch.study}, std::pair{"--series", fetch.series},
                                      std::pair{"--instance", fetch.instance}}) {
        if (!uid.empty() && !is_uid(uid))
            return usage_error("E-NET-022",
                               fmt::format("{} takes a UID: digits and points, at most 64", option),
                               uid.substr(0, 100), "list the UIDs with anatomesh query");
    }
    if (!fetch.instance.empty() && fetch.series.empty())
        return usage_error("E-CMD-008", "--instance needs --series", "", "give both options");
    return Nothing{};
}

Status check_destination(const FetchVerbOptions& options, const ConnectOptions& connecting) {
    const FetchOptions& fetch = options.fetch;
    const bool moves = !fetch.move_to.empty();
    if (moves && !is_ae_title(fetch.move_to))
        return usage_error("E-CMD-001", "--move-to takes an AE title: 1 to 16 ASCII characters, no backslash",
                           fetch.move_to, "give an AE title that the archive knows");
    if (moves && !connecting.peer.dicom)
        return usage_error("E-CMD-008", "--move-to does not apply to DICOMweb, which has no C-MOVE", "",
                           "leave out --move-to");
    if ((options.port != 0 || options.address_given) && !moves)
        return usage_error("E-CMD-008", "--port and --address need --move-to", "",
                           "leave them out, or give --move-to");
    const bool receives = !moves || options.port != 0;
    if (receives && options.folder.empty())
        return usage_error("E-CMD-001", "the folder for the fetched objects is missing", "",
                           "give -o FOLDER");
    if (!receives && options.quota_mb > 0)
        return usage_error("E-CMD-008", "--quota does not apply: the archive sends to another program", "",
                           "leave out --quota, or give --port to receive here");
    if (!receives && !options.folder.empty())
        return usage_error("E-CMD-008", "-o does not apply: the archive sends to another program", "",
                           "leave out -o, or give --port to receive here");
    return Nothing{};
}

// An archive counts as failed what was refused here, and may call completed what never came.
std::uint64_t objects_lost(const FetchResult& result, const FetchVerbOptions& options) {
    const std::uint64_t refused = std::max(result.failed, result.refused + result.unasked) - result.unasked;
    if (options.folder.empty()) return refused;
    const std::uint64_t came = result.stored + result.there_already + result.refused + result.unasked;
    return refused + (result.sent > came ? result.sent - came : 0);
}

Error loss(const FetchResult& result, std::uint64_t lost, const FetchVerbOptions& options) {
    Place place{"", "", "", "", options.network.peer};
    std::string why = "the archive could not send them, or did not";
    if (!result.refusals.empty()) {
        const RefusedObject& first = result.refusals.front();
        why = first.reason;
        if (!first.path.empty()) place.file = options.folder + "/" + first.path;
    }
    return {ErrorKind::file, "E-NET-015",
            fmt::format("{} did not arrive or cannot be stored: {}", counted(lost, "object"), why),
            std::move(place),
            "the objects that arrived are kept; mend what the message names, then run fetch again"};
}

// Other objects than those asked for are no harmless surplus: who sends them may have mixed up patients.
Error strangers(const FetchResult& result, std::uint64_t lost, const FetchVerbOptions& options) {
    return {
        ErrorKind::file,
        "E-NET-024",
        fmt::format("the archive sent {} that {} not asked for: {} not stored; {} stored or there already{}",
                    counted(result.unasked, "object"), result.unasked == 1 ? "was" : "were",
                    result.unasked == 1 ? "it is" : "they are",
                    counted(result.stored + result.there_already, "object"),
                    lost > 0 ? fmt::format(", {} did not arrive", counted(lost, "object")) : ""),
        {"", "", "", "", options.network.peer},
        "do not use the study before the archive's operator has looked into it: it may mix up patients"};
}

Status answer_of(const FetchResult& result, const FetchVerbOptions& options, Session& session) {
    nlohmann::ordered_json answer{{"peer", options.network.peer},
                                  {"sent", result.sent},
                                  {"failed", result.failed},
                                  {"stored", result.stored},
                                  {"there_already", result.there_already},
                                  {"refused", result.refused},
                                  {"not_asked_for", result.unasked},
                                  {"bytes", result.bytes},
                                  {"reasons", result.reasons}};
    answer["not_stored"] = nlohmann::ordered_json::array();
    for (const RefusedObject& each : result.refusals)
        answer["not_stored"].push_back({{"object", each.path}, {"reason", each.reason}});
    std::string text;
    if (options.folder.empty()) {
        text = fmt::format("{} sent to {}\n", counted(result.sent, "object"), options.fetch.move_to);
    } else {
        answer["folder"] = options.folder;
        text = fmt::format("{} stored in {}, {:.1f} MB, {} there already\n", counted(result.stored, "object"),
                           options.folder, static_cast<double>(result.bytes) / 1e6, result.there_already);
    }
    ANATOMESH_CHECK_STATUS(give_summary(session, std::move(answer), text));
    const Place place{"", "", "", "", options.network.peer};
    const std::uint64_t lost = objects_lost(result, options);
    if (result.unasked > 0) return strangers(result, lost, options);
    if (lost > 0) return loss(result, lost, options);
    if (result.sent + result.stored + result.there_already == 0)
        return Error{ErrorKind::input, "E-NET-023", "the archive has no objects of these UIDs", place,
                     "list its objects with anatomesh query"};
    return Nothing{};
}

Status run_fetch(FetchVerbOptions options, Session& session) {
    ANATOMESH_CHECK_STATUS(check_uids(options.fetch));
    ANATOMESH_TRY(const ConnectOptions connecting, connect_options(options.network, session.limits.request));
    ANATOMESH_CHECK_STATUS(check_destination(options, connecting));
    options.fetch.port = static_cast<std::uint16_t>(options.port);
    RunContext& context = session.context;
    std::optional<ObjectStore> store;
    if (!options.folder.empty()) {
        ObjectStoreOptions storing;
        storing.quota_bytes = static_cast<std::uint64_t>(options.quota_mb * 1e6);
        storing.max_object_bytes = session.limits.input.max_file_bytes;
        ANATOMESH_TRY(ObjectStore opened, ObjectStore::open(options.folder, storing));
        store.emplace(std::move(opened));
    }
    std::optional<ProgressBar> bar;
    if (!session.quiet) {
        bar.emplace();
        bar->begin("fetching", 0, 1);
        context.progress = [&bar](const std::string&, double share) { bar->update(share); };
    }
    const auto result = fetch_objects(store ? &*store : nullptr, options.fetch, connecting, context);
    context.progress = nullptr;
    bar.reset();
    if (!result.ok()) return result.error();
    return answer_of(result.value(), options, session);
}

}  // namespace

Work declare_fetch(CLI::App& verb) {
    auto options = std::make_shared<FetchVerbOptions>();
    add_network_options(verb, "--from", options->network);
    add_text(verb, "--study", options->fetch.study, "UID", "The study to fetch.")->required();
    add_text(verb, "--series", options->fetch.series, "UID", "Fetch only this series of the study.");
    add_text(verb, "--instance", options->fetch.instance, "UID", "Fetch only this instance of the series.");
    add_text(verb, "-o,--output", options->folder, "FOLDER",
             "Where objects are stored: FOLDER/STUDY/SERIES/INSTANCE.dcm.");
    add_text(
        verb, "--move-to", options->fetch.move_to, "AE",
        "The archive sends to this AE title (C-MOVE). Default: it sends over the same connection (C-GET).");
    add_count(
        verb, "--port", options->port, 1, 65535,
        "With --move-to: receive at this port, 1 to 65535, which the archive must know for that AE title.");
    add_text(verb, "--address", options->fetch.address, "ADDRESS",
             "With --port: network address to listen at. Default: 127.0.0.1.")
        ->each([options](const std::string&) { options->address_given = true; });
    add_quota_option(verb, options->quota_mb);
    group_new_options(verb, option_group::request);
    for (const char* name : {"--output", "--quota"}) verb.get_option(name)->group(option_group::outputs);
    return [options](Session& session) { return run_fetch(*options, session); };
}

}  // namespace anatomesh
