#include "anatomesh_io/network/dicom_json.h"

#include <fmt/format.h>

#include "anatomesh_io/contour/number_text.h"

namespace anatomesh {

namespace {

using Json = nlohmann::json;

// Values nested deeper are refused, so that a hostile answer takes no memory. [levels; >= 4; B]
constexpr int deepest = 64;

// A content type is shown no further: it comes from outside. [characters; >= 20; B]
constexpr std::size_t longest_shown_type = 80;
constexpr const char* blanks = " \t\r\n";

bool is_too_deep(std::string_view text) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            if (++depth > deepest) return true;
        } else if (c == ']' || c == '}') {
            --depth;
        }
    }
    return false;
}

std::string text_of_value(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_unsigned()) return fmt::format("{}", value.get<std::uint64_t>());
    if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
    if (value.is_number_float()) return fmt::format("{}", value.get<double>());
    if (value.is_object() && value.contains("Alphabetic")) return text_of_value(value["Alphabetic"]);
    return {};
}

const Json* values_of(const Json& data_set, DicomTag tag) {
    const std::string name = fmt::format("{:04X}{:04X}", tag.group, tag.element);
    if (!data_set.is_object()) return nullptr;
    const auto element = data_set.find(name);
    if (element == data_set.end() || !element->is_object()) return nullptr;
    const auto values = element->find("Value");
    return values != element->end() && values->is_array() && !values->empty() ? &*values : nullptr;
}

}  // namespace

std::string what_came(std::string_view content_type, std::string_view content) {
    std::string text(content_type.empty() ? "no content type" : content_type.substr(0, longest_shown_type));
    const std::size_t start = content.find_first_not_of(blanks);
    if (start == std::string_view::npos) return text + ", an empty body";
    return content[start] == '<' ? text + ", which looks like a web page, perhaps for a login" : text;
}

Result<Json> parse_dicom_json(std::string_view text, std::string_view content_type, const std::string& url) {
    if (text.find_first_not_of(blanks) == std::string_view::npos) return Json();
    const auto wrong = [&](const std::string& what) {
        return Error{ErrorKind::file,
                     "E-NET-018",
                     what,
                     {"", "", "", "", url},
                     "check that the URL is that of a DICOMweb service"};
    };
    if (is_too_deep(text)) return wrong("the answer is nested too deeply");
    Json parsed = Json::parse(text, nullptr, false);
    if (parsed.is_discarded())
        return wrong("the answer is no DICOM JSON: what came is " + what_came(content_type, text));
    return parsed;
}

std::string json_text_of(const Json& data_set, DicomTag tag) {
    const Json* values = values_of(data_set, tag);
    std::string text;
    if (!values) return text;
    for (std::size_t i = 0; i < values->size(); ++i)
        text += (i > 0 ? "\\" : "") + text_of_value((*values)[i]);
    return text;
}

std::optional<std::uint32_t> json_number_of(const Json& data_set, DicomTag tag) {
    const Json* values = values_of(data_set, tag);
    if (!values) return std::nullopt;
    return parse_integer<std::uint32_t>(text_of_value((*values)[0]));
}

}  // namespace anatomesh
