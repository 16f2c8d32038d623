#include "anatomesh/base/result.h"

namespace anatomesh {

namespace {

void append(std::string& line, const char* label, const std::string& text) {
    if (text.empty()) return;
    if (!line.empty()) line += ", ";
    line += label;
    line += text;
}

std::string place_text(const Place& place) {
    std::string line;
    append(line, "", place.file);
    append(line, "structure ", place.structure);
    append(line, "slice ", place.slice);
    append(line, "contour ", place.contour);
    append(line, "value ", place.value);
    return line;
}

std::string line_of(const std::string& code, const Place& place, const std::string& message,
                    const char* tail_label, const std::string& tail) {
    std::string line = code;
    const std::string where = place_text(place);
    if (!where.empty()) line += " " + where;
    line += ": " + message;
    if (!tail.empty()) line += std::string(" (") + tail_label + tail + ")";
    // Names come from files: a line stays one line, and sends nothing to a terminal but text.
    for (char& c : line) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
    }
    return line;
}

}  // namespace

std::string to_line(const Error& error) {
    return line_of(error.code, error.place, error.message, "next: ", error.next_step);
}

std::string to_line(const Warning& warning) {
    return line_of(warning.code, warning.place, warning.message, "", warning.what_was_done);
}

}  // namespace anatomesh
