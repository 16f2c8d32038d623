#include "answer.h"

#include <nlohmann/json.hpp>

namespace anatomesh {

namespace {

nlohmann::ordered_json warnings_json(const std::vector<Warning>& warnings) {
    auto list = nlohmann::ordered_json::array();
    for (const Warning& warning : warnings) {
        nlohmann::ordered_json entry{{"code", warning.code}, {"message", warning.message}};
        const auto add = [&](const char* name, const std::string& text) {
            if (!text.empty()) entry[name] = text;
        };
        add("file", warning.place.file);
        add("slice", warning.place.slice);
        add("structure", warning.place.structure);
        add("contour", warning.place.contour);
        add("value", warning.place.value);
        add("what_was_done", warning.what_was_done);
        list.push_back(std::move(entry));
    }
    return list;
}

}  // namespace

std::string json_text(const Session& session, nlohmann::ordered_json answer) {
    answer["warnings"] = warnings_json(session.context.warnings);
    return answer.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Status give_answer(Session& session, nlohmann::ordered_json answer, const std::string& text) {
    if (!session.json) return print_answer(session, printable(text));
    return print_answer(session, json_text(session, std::move(answer)));
}

Status give_summary(Session& session, nlohmann::ordered_json answer, const std::string& text) {
    if ((session.quiet || session.output_closed) && !session.json) return Nothing{};
    return give_answer(session, std::move(answer), text);
}

nlohmann::ordered_json inputs_json(const std::vector<InputReport>& files) {
    auto list = nlohmann::ordered_json::array();
    for (const InputReport& file : files) {
        list.push_back(
            {{"file", file.file}, {"format", file.format}, {"sha256", file.sha256}, {"bytes", file.bytes}});
    }
    return list;
}

}  // namespace anatomesh
