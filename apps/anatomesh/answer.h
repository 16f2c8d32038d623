// Answers of the verbs, as text for people or as one JSON object for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "anatomesh/base/result.h"
#include "anatomesh/measure/report.h"
#include "session.h"

namespace anatomesh {

// Prints `answer` with the run's warnings when the session answers in JSON, else `text` with control
// characters replaced; text is left out when the session is quiet, or standard output closed, and the answer
// is a mere summary.
Status give_answer(Session& session, nlohmann::ordered_json answer, const std::string& text);
Status give_summary(Session& session, nlohmann::ordered_json answer, const std::string& text);

// `answer` as text, with the warnings of the run.
std::string json_text(const Session& session, nlohmann::ordered_json answer);

nlohmann::ordered_json inputs_json(const std::vector<InputReport>& files);

}  // namespace anatomesh
