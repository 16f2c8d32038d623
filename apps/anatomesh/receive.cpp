// anatomesh receive: a DICOM receiver that sorts what comes into a folder, and may model it.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "anatomesh/base/plural.h"
#include "anatomesh_io/network/receiver.h"
#include "answer.h"
#include "help_text.h"
#include "network_options.h"
#include "option_values.h"
#include "verbs.h"
#include "watch_studies.h"

namespace anatomesh {

namespace {

struct ReceiveVerbOptions {
    std::string folder;
    ReceiverOptions receiver;
    std::uint32_t port = 11112;
    std::vector<std::string> allowed;
    double quota_mb = 0;  // 0: none
    bool plain = false;
    TlsFiles tls;
    bool model = false;
    WatchOptions watch;
    bool settle_given = false, model_time_given = false;
};

// "AE" from this machine, "AE@HOST", "@HOST"; HOST may be "*".
Result<AllowedPeer> allowed_peer(const std::string& text) {
    const std::size_t at = text.find('@');
    AllowedPeer peer;
    peer.title = text.substr(0, at);
    const std::string host = at == std::string::npos ? "" : text.substr(at + 1);
    const bool names_host = at != std::string::npos;
    if ((!peer.title.empty() && !is_ae_title(peer.title)) || (names_host && host.empty()) ||
        (!names_host && peer.title.empty()))
        return usage_error("E-NET-009", "the value of --allow is neither an AE title nor a host",
                           text.substr(0, 200),
                           "--allow takes AE (from this machine), AE@HOST or @HOST; HOST may be *");
    if (host == "*") return peer;
    if (!names_host) {
        peer.addresses = {"127.0.0.1", "::1"};
        return peer;
    }
    peer.addresses = addresses_of(host);
    if (peer.addresses.empty())
        return usage_error("E-NET-009", "the address of the host is not known", text.substr(0, 200),
                           "check the name of the host, or give its address");
    return peer;
}

// Whoever lets others than this machine in says whom, and whether without TLS.
Status check_exposure(const ReceiveVerbOptions& options) {
    const std::vector<std::string> addresses = addresses_of(options.receiver.address);
    bool is_local = !addresses.empty();
    for (const std::string& address : addresses) is_local = is_local && is_loopback(address);
    const std::string& address = options.receiver.address;
    if (options.plain && !options.tls.empty())
        return usage_error("E-CMD-008", "--plain does not apply together with TLS", "", "leave out --plain");
    if (!options.tls.empty() && (options.tls.certificate.empty() || options.tls.key.empty()))
        return usage_error("E-CMD-008", "TLS needs --tls-certificate and --tls-key", "",
                           "give both as PEM files");
    if (is_local) return Nothing{};
    if (options.allowed.empty())
        return usage_error("E-NET-020", "other machines can reach this address, but no sender is allowed",
                           address, "give --allow AE@HOST for each sender");
    if (options.tls.empty() && !options.plain)
        return usage_error("E-NET-020",
                           "other machines can reach this address, which needs encryption by TLS", address,
                           "give --tls-certificate and --tls-key, or --plain in a network that you trust");
    return Nothing{};
}

Status run_receive(ReceiveVerbOptions options, Session& session) {
    ANATOMESH_CHECK_STATUS(check_exposure(options));
    ReceiverOptions& receiving = options.receiver;
    receiving.port = static_cast<std::uint16_t>(options.port);
    for (const std::string& text : options.allowed) {
        ANATOMESH_TRY(AllowedPeer peer, allowed_peer(text));
        receiving.allowed.push_back(std::move(peer));
    }
    if ((options.settle_given || options.model_time_given || options.watch.keep_patient_ids) &&
        !options.model)
        return usage_error("E-CMD-008",
                           "--settle, --model-time and --keep-patient-ids do not apply without --model", "",
                           "leave them out, or give --model");
    std::optional<TlsContext> tls;
    if (!options.tls.empty()) {
        ANATOMESH_TRY(tls, TlsContext::server(options.tls));
        receiving.tls = &*tls;
    }
    ObjectStoreOptions storing;
    storing.quota_bytes = static_cast<std::uint64_t>(options.quota_mb * 1e6);
    storing.max_object_bytes = session.limits.input.max_file_bytes;
    ANATOMESH_TRY(ObjectStore store, ObjectStore::open(options.folder, storing));

    const auto say = [&session](const std::string& line) {
        if (!session.quiet) print_line("anatomesh: " + line);
    };
    std::optional<StudyWatch> watch;
    if (options.model) watch.emplace(options.folder, options.watch, say);
    std::set<std::string> studies, series;
    ReceiverHooks hooks;
    hooks.listening = [&](std::uint16_t port) {
        say(fmt::format("listening at {} port {} as {}{}", receiving.address, port, receiving.title,
                        receiving.tls ? ", TLS" : ""));
    };
    hooks.log = say;
    hooks.ended = [&](const StoreOutcome& outcome) {
        if (outcome.end != StoreEnd::stored && outcome.end != StoreEnd::there_already) return;
        series.insert(outcome.path.substr(0, outcome.path.rfind('/')));
        studies.insert(outcome.path.substr(0, outcome.path.find('/')));
        if (watch) watch->arrived(outcome);
    };
    hooks.tick = [&](const std::vector<std::string>& busy) {
        if (watch) watch->tick(busy);
        return false;
    };
    ANATOMESH_TRY(const ReceiverSummary summary, receive_objects(store, receiving, hooks, session.context));
    nlohmann::ordered_json answer{{"folder", options.folder},
                                  {"associations", summary.associations},
                                  {"rejected", summary.rejected},
                                  {"stored", summary.stored},
                                  {"there_already", summary.there_already},
                                  {"refused", summary.refused},
                                  {"bytes", summary.bytes},
                                  {"studies", studies.size()},
                                  {"series", series.size()}};
    std::string text =
        fmt::format("{} stored in {}, {} there already, {} refused; {}, {}\n",
                    counted(summary.stored, "object"), options.folder, summary.there_already, summary.refused,
                    counted(studies.size(), "study", "studies"), counted(series.size(), "series", "series"));
    if (watch) {
        watch->end();
        answer["models"] = watch->models();
        text += fmt::format("{} made\n", counted(watch->models(), "model"));
    }
    return give_summary(session, std::move(answer), text);
}

}  // namespace

Work declare_receive(CLI::App& verb) {
    auto options = std::make_shared<ReceiveVerbOptions>();
    ReceiverOptions& receiver = options->receiver;
    add_text(verb, "FOLDER", options->folder, "FOLDER",
             "Where objects are stored: FOLDER/STUDY/SERIES/INSTANCE.dcm.")
        ->required();
    add_count(verb, "--port", options->port, 0, 65535,
              "Port to listen at, 0 to 65535. 0 takes any free one. Default: 11112.");
    add_text(verb, "--address", receiver.address, "ADDRESS",
             "Network address to listen at. Default: 127.0.0.1, for this machine only.");
    add_title_option(verb, receiver.title);
    add_texts(verb, "--allow", options->allowed, "AE@HOST",
              "Who may send: AE (from this machine), AE@HOST or @HOST; HOST may be *. Repeatable. Default: "
              "this machine.");
    add_count(verb, "--associations", receiver.associations, 1, 1000,
              "Connections at the same time, 1 to 1000. Default: 8.");
    add_timeout_option(verb, receiver.timeout_seconds);
    add_quota_option(verb, options->quota_mb);
    add_tls_files(verb, options->tls);
    verb.add_flag("--plain", options->plain, "Accept connections of other machines without TLS encryption.");
    group_new_options(verb, option_group::connection);
    verb.add_flag("--model", options->model,
                  "Make a model of each study that has an RTSTRUCT or SEG, once all of it has arrived.");
    verb.add_flag(
        "--keep-patient-ids", options->watch.keep_patient_ids,
        "With --model: keep the patient's identity in models, so that they can be sent back to the study.");
    add_number(
        verb, "--settle", options->watch.settle_seconds, 0.1, 86400, "SECONDS",
        "With --model: wait until nothing of a study has arrived for this long, 0.1 to 86400 s. Default: 30.")
        ->each([options](const std::string&) { options->settle_given = true; });
    add_number(
        verb, "--model-time", options->watch.model_seconds, 1, 86400, "SECONDS",
        "With --model: end a model that takes longer, 1 to 86400 s, so that other studies have their turn. "
        "Default: 1800.")
        ->each([options](const std::string&) { options->model_time_given = true; });
    group_new_options(verb, option_group::outputs);
    return [options](Session& session) { return run_receive(*options, session); };
}

}  // namespace anatomesh
