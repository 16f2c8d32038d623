// options_json: options as used, for the report and the answers of the verbs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace anatomesh {

// An object: of an option that was used once its value, of one that may be repeated, and was, a list of its
// values in the order given.
inline nlohmann::ordered_json options_json(const std::vector<std::pair<std::string, std::string>>& options) {
    nlohmann::ordered_json all = nlohmann::ordered_json::object();
    for (const auto& [name, value] : options) {
        nlohmann::ordered_json& known = all[name];
        if (known.is_null()) {
            known = value;
            continue;
        }
        if (!known.is_array()) known = nlohmann::ordered_json::array({known});
        known.push_back(value);
    }
    return all;
}

}  // namespace anatomesh
