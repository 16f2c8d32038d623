// anatomesh send: DICOM objects to a PACS or a planning system.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "anatomesh/base/plural.h"
#include "anatomesh_io/network/send_objects.h"
#include "answer.h"
#include "network_options.h"
#include "option_values.h"
#include "progress_bar.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct SendVerbOptions {
    std::vector<std::string> inputs;
    NetworkOptions network;
};

Status run_send(const SendVerbOptions& options, Session& session) {
    ANATOMESH_TRY(const ConnectOptions connecting, connect_options(options.network, session.limits.request));
    RunContext& context = session.context;
    std::uint64_t skipped = 0;
    ANATOMESH_TRY(const std::vector<OutgoingObject> objects, find_objects(options.inputs, skipped, context));
    std::optional<ProgressBar> bar;
    if (!session.quiet) {
        bar.emplace();
        bar->begin("sending", 0, 1);
        context.progress = [&bar](const std::string&, double share) { bar->update(share); };
    }
    auto result = send_objects(objects, connecting, context);
    context.progress = nullptr;
    bar.reset();
    if (!result.ok()) return result.error();
    const SendResult& sent = result.value();

    nlohmann::ordered_json answer{
        {"peer", options.network.peer}, {"objects", objects.size()},
        {"stored", sent.stored},        {"bytes", sent.bytes},
        {"skipped", skipped},           {"failed", nlohmann::ordered_json::array()}};
    std::string text =
        fmt::format("{} of {} stored at {}, {:.1f} MB\n", sent.stored, counted(objects.size(), "object"),
                    options.network.peer, static_cast<double>(sent.bytes) / 1e6);
    for (const SentObject& each : sent.objects) {
        if (each.is_stored()) continue;
        const std::string status = fmt::format("0x{:04X}", each.status);
        const std::string& path = objects[each.index].path;
        answer["failed"].push_back({{"file", path}, {"status", status}, {"reason", each.reason}});
        text += fmt::format("  {}: {} ({})\n", path, each.reason, status);
    }
    ANATOMESH_CHECK_STATUS(give_summary(session, std::move(answer), text));
    if (sent.stored == objects.size()) return Nothing{};
    return Error{ErrorKind::file,
                 "E-NET-014",
                 fmt::format("{} of {} were not stored", objects.size() - sent.stored,
                             counted(objects.size(), "object")),
                 {"", "", "", "", options.network.peer},
                 "the answer lists them with the reasons; look into the log of the archive"};
}

}  // namespace

Work declare_send(CLI::App& verb) {
    auto options = std::make_shared<SendVerbOptions>();
    add_texts(verb, "INPUT", options->inputs, "PATH", "DICOM files and folders of DICOM files.")
        ->required()
        ->allow_extra_args(true)
        ->expected(-1);  // one or more
    add_network_options(verb, "--to", options->network);
    return [options](Session& session) { return run_send(*options, session); };
}

}  // namespace anatomesh
