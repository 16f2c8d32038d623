#include "anatomesh_io/image/property_list.h"

#include <fmt/format.h>

#include <array>

#include "anatomesh_io/image/raw_image.h"

namespace anatomesh {

namespace {

// Values nested deeper are refused, so that a hostile file takes no memory. [levels; >= 4; B]
constexpr std::size_t deepest = 32;
// A file with more values is refused, before they take all memory. [values; >= 100; B]
constexpr std::size_t most_values = 100000;

std::string unescaped(std::string_view text) {
    constexpr std::array<std::pair<std::string_view, char>, 5> entities = {
        {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};
    std::string plain;
    while (!text.empty()) {
        std::size_t used = 1;
        char c = text.front();
        for (const auto& [entity, meaning] : entities)
            if (text.starts_with(entity)) {
                used = entity.size();
                c = meaning;
                break;
            }
        plain += c;
        text.remove_prefix(used);
    }
    return plain;
}

// The next tag, without its brackets, and the text before it; comments, declarations and the DTD are passed
// over. Entities of a DTD are not known, so they cannot multiply.
struct Tag {
    std::string_view text_before, name;
    bool closing = false, empty = false;
};

bool next_tag(std::string_view& xml, Tag& tag) {
    while (true) {
        const std::size_t begin = xml.find('<');
        if (begin == std::string_view::npos) return false;
        const bool comment = xml.substr(begin).starts_with("<!--");
        const std::size_t end = comment ? xml.find("-->", begin + 4) : xml.find('>', begin);
        if (end == std::string_view::npos) return false;
        tag.text_before = xml.substr(0, begin);
        std::string_view inner = xml.substr(begin + 1, end - begin - 1);
        xml.remove_prefix(end + (comment ? 3 : 1));
        if (comment || inner.starts_with("!") || inner.starts_with("?")) continue;
        tag.closing = inner.starts_with("/");
        tag.empty = !tag.closing && inner.ends_with("/");  // "</>" is the end of nothing
        if (tag.closing) inner.remove_prefix(1);
        if (tag.empty) inner.remove_suffix(1);
        tag.name = inner.substr(0, inner.find_first_of(" \t\r\n"));
        return true;
    }
}

struct Container {
    bool dictionary = false;
    std::string path;  // of the container itself
    std::string key;   // the last key seen in a dictionary
};

std::string path_of_value(const std::vector<Container>& open) {
    if (open.empty()) return "";
    const Container& top = open.back();
    if (!top.dictionary) return top.path;
    return top.path.empty() ? top.key : top.path + "/" + top.key;
}

}  // namespace

Result<PropertyList> parse_property_list(std::string_view xml, const std::string& path) {
    const auto wrong = [&](const char* what) {
        return image_error("E-INV-004", std::string("main.plist is not readable: ") + what, path, "",
                           "save the project again");
    };
    PropertyList values;
    std::vector<Container> open;
    bool seen_container = false;
    Tag tag;
    while (next_tag(xml, tag)) {
        if (tag.name == "plist") continue;
        if (tag.name == "dict" || tag.name == "array") {
            if (tag.empty) continue;
            if (tag.closing) {
                if (open.empty() || open.back().dictionary != (tag.name == "dict"))
                    return wrong("tags cross");
                open.pop_back();
                continue;
            }
            if (open.size() == deepest) return wrong("nested too deeply");
            open.push_back({tag.name == "dict", path_of_value(open), ""});
            seen_container = true;
            continue;
        }
        // A scalar: its text runs to the closing tag of the same name.
        if (tag.closing || open.empty()) return wrong("a value out of place");
        std::string text(tag.name == "true" || tag.name == "false" ? tag.name : "");
        if (!tag.empty) {
            const std::string_view name = tag.name;
            if (!next_tag(xml, tag) || !tag.closing || tag.name != name) return wrong("a value without end");
            if (text.empty()) text = unescaped(trimmed(tag.text_before));
            tag.name = name;
        }
        if (tag.name == "key") {
            if (!open.back().dictionary || text.size() > 256) return wrong("a key out of place");
            open.back().key = std::move(text);
            continue;
        }
        if (values.size() == most_values) return wrong("too many values");
        values.emplace_back(path_of_value(open), std::move(text));
    }
    if (!seen_container || !open.empty()) return wrong("it ends early");
    return values;
}

std::vector<std::string_view> values_at(const PropertyList& list, std::string_view key_path) {
    std::vector<std::string_view> found;
    for (const auto& [path, value] : list)
        if (path == key_path) found.push_back(value);
    return found;
}

}  // namespace anatomesh
