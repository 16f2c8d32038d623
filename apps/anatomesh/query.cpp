// anatomesh query: what an archive has.
#include "anatomesh_io/network/query.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "anatomesh/base/plural.h"
#include "answer.h"
#include "command_words.h"
#include "help_text.h"
#include "network_options.h"
#include "option_values.h"
#include "verbs.h"

namespace anatomesh {

namespace {

struct QueryVerbOptions {
    NetworkOptions network;
    QueryOptions query;
    std::string level = "study";
    std::vector<std::string> matches;
    bool keep_patient_ids = false;
};

Status add_match(const std::string& text, QueryOptions& query) {
    const std::size_t equals = text.find('=');
    const std::string keyword = text.substr(0, equals);
    std::vector<std::string> known;
    for (const QueryAttribute& each : query_attributes()) known.emplace_back(each.keyword);
    const QueryAttribute* attribute = find_attribute(keyword);
    if (!attribute || equals == std::string::npos) {
        const std::string near = nearest_word(keyword, known);
        return usage_error("E-NET-021", "--match needs KEYWORD=VALUE with a keyword that archives can match",
                           text.substr(0, 100),
                           near.empty()
                               ? "for example --match Modality=CT; docs/network.md lists the keywords"
                               : fmt::format("did you mean {}=VALUE?", near));
    }
    if (attribute->level > query.level)
        return usage_error("E-NET-021", "the keyword does not exist at this level of the query", keyword,
                           "give --level series or --level instance");
    query.match[keyword] = text.substr(equals + 1);
    return Nothing{};
}

Status check_uid(const std::string& option, const std::string& uid) {
    if (uid.empty() || is_uid(uid)) return Nothing{};
    return usage_error("E-NET-022", fmt::format("{} takes a UID: digits and points, at most 64", option),
                       uid.substr(0, 100), "list the UIDs with anatomesh query");
}

std::vector<const QueryAttribute*> shown_attributes(const QueryVerbOptions& options,
                                                    const QueryResult& result) {
    std::vector<const QueryAttribute*> shown;
    for (const QueryAttribute& each : query_attributes()) {
        if (each.is_identifying && !options.keep_patient_ids) continue;
        const bool is_said = std::any_of(result.answers.begin(), result.answers.end(),
                                         [&](const auto& answer) { return answer.contains(each.keyword); });
        if (is_said) shown.push_back(&each);
    }
    return shown;
}

std::string table(const std::vector<const QueryAttribute*>& shown, const QueryResult& result) {
    const auto cell = [](const std::map<std::string, std::string>& answer, const char* keyword) {
        const auto found = answer.find(keyword);
        return found == answer.end() ? std::string("-") : found->second;
    };
    std::string text;
    std::vector<std::size_t> widths;
    for (const QueryAttribute* each : shown) {
        std::size_t width = std::string(each->keyword).size();
        for (const auto& answer : result.answers) width = std::max(width, cell(answer, each->keyword).size());
        widths.push_back(width);
        text += fmt::format("{:<{}}  ", each->keyword, width);
    }
    if (!shown.empty()) text += "\n";
    for (const auto& answer : result.answers) {
        for (std::size_t i = 0; i < shown.size(); ++i)
            text += fmt::format("{:<{}}  ", cell(answer, shown[i]->keyword), widths[i]);
        text += "\n";
    }
    return text;
}

Status run_query(QueryVerbOptions options, Session& session) {
    QueryOptions& query = options.query;
    query.level = options.level == "study"    ? QueryLevel::study
                  : options.level == "series" ? QueryLevel::series
                                              : QueryLevel::instance;
    ANATOMESH_CHECK_STATUS(check_uid("--study", query.study));
    ANATOMESH_CHECK_STATUS(check_uid("--series", query.series));
    for (const std::string& text : options.matches) {
        ANATOMESH_CHECK_STATUS(add_match(text, query));
    }
    ANATOMESH_TRY(const ConnectOptions connecting, connect_options(options.network, session.limits.request));
    ANATOMESH_TRY(const QueryResult result, query_peer(query, connecting, session.context));
    if (result.is_cut)
        session.context.warn({"W-NET-001",
                              "the archive has more answers than are shown",
                              {"", "", "", "", fmt::format("{}", query.most_answers)},
                              "the first answers are shown; --most allows more, --match selects fewer"});
    const auto shown = shown_attributes(options, result);
    nlohmann::ordered_json answer{{"peer", options.network.peer}, {"level", options.level}};
    answer["answers"] = nlohmann::ordered_json::array();
    for (const auto& each : result.answers) {
        nlohmann::ordered_json item = nlohmann::ordered_json::object();
        for (const QueryAttribute* attribute : shown)
            if (const auto found = each.find(attribute->keyword); found != each.end())
                item[attribute->keyword] = found->second;
        answer["answers"].push_back(std::move(item));
    }
    const std::string text = table(shown, result) + counted(result.answers.size(), "answer") + "\n";
    return give_answer(session, std::move(answer), text);
}

}  // namespace

Work declare_query(CLI::App& verb) {
    auto options = std::make_shared<QueryVerbOptions>();
    add_network_options(verb, "--from", options->network);
    add_choice(verb, "--level", options->level, {"study", "series", "instance"},
               "What to list. Default: study.");
    add_text(verb, "--study", options->query.study, "UID", "List only what belongs to this study.");
    add_text(verb, "--series", options->query.series, "UID", "List only what belongs to this series.");
    add_texts(
        verb, "--match", options->matches, "KEYWORD=VALUE",
        "List only what matches, such as PatientID=17 or StudyDate=20260101-. * and ? stand for any text. "
        "Repeatable.");
    add_count(verb, "--most", options->query.most_answers, 1, 1000000,
              "Largest number of answers, 1 to 1000000. Default: 1000.");
    verb.add_flag("--keep-patient-ids", options->keep_patient_ids,
                  "Also show names, identifiers, dates and descriptions of patients and studies.");
    group_new_options(verb, option_group::request);
    return [options](Session& session) { return run_query(*options, session); };
}

}  // namespace anatomesh
