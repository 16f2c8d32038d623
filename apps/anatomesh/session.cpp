#include "session.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

namespace anatomesh {

namespace {

// Writes all of `text`; the errno of the failure, or 0.
int write_all(int descriptor, std::string_view text) {
    while (!text.empty()) {
        const ssize_t written = ::write(descriptor, text.data(), text.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            return errno;
        }
        text.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
}

nlohmann::ordered_json to_json(const Error& error) {
    nlohmann::ordered_json place;
    const auto add = [&](const char* name, const std::string& text) {
        if (!text.empty()) place[name] = text;
    };
    add("file", error.place.file);
    add("slice", error.place.slice);
    add("structure", error.place.structure);
    add("contour", error.place.contour);
    add("value", error.place.value);
    nlohmann::ordered_json out{
        {"code", error.code}, {"message", error.message}, {"exit_code", exit_code(error)}};
    if (!place.empty()) out["place"] = place;
    if (!error.next_step.empty()) out["next_step"] = error.next_step;
    return {{"error", out}};
}

}  // namespace

int exit_code(const Error& error) {
    return static_cast<int>(error.kind);
}

Status print_answer(Session& session, std::string_view text) {
    session.answered = true;  // even when it fails: half an answer is not to be followed by another document
    const int failure = session.output_closed ? EBADF : write_all(STDOUT_FILENO, text);
    if (failure == 0 || failure == EPIPE) return Nothing{};
    return Error{ErrorKind::file,
                 "E-CMD-009",
                 session.output_closed
                     ? std::string("standard output is closed")
                     : fmt::format("standard output cannot be written: {}", std::strerror(failure)),
                 {},
                 "redirect standard output to a file, or give --quiet to a command that writes files"};
}

void print_line(const std::string& line) {
    write_all(STDERR_FILENO, on_one_line(line) + "\n");
}

void print_error(const Session& session, const Error& error) {
    print_line(fmt::format("anatomesh: {}", to_line(error)));
    if (session.json && !session.answered) {
        const auto text =
            to_json(error).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
        write_all(STDOUT_FILENO, text + "\n");
    }
}

void print_warnings(const Session& session) {
    if (session.quiet) return;
    // So many warnings of one code are printed; then their number is. [lines; >= 1; C]
    constexpr int shown_per_code = 5;
    std::map<std::string, int> count;
    for (const Warning& warning : session.context.warnings) {
        if (++count[warning.code] <= shown_per_code) print_line("warning: " + to_line(warning));
    }
    for (const auto& [code, times] : count) {
        if (times > shown_per_code)
            print_line(fmt::format("warning: {}: {} more like it", code, times - shown_per_code));
    }
}

std::string printable(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        // U+0080 to U+009F, the second set of control characters, is 0xC2 0x80 to 0xC2 0x9F in UTF-8.
        const bool second_set =
            c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0;
        if (second_set) ++i;
        out += (c < 0x20 && c != '\n') || c == 0x7F || second_set ? '?' : text[i];
    }
    return out;
}

std::string on_one_line(std::string_view text) {
    std::string out = printable(text);
    std::replace(out.begin(), out.end(), '\n', '?');
    return out;
}

}  // namespace anatomesh
