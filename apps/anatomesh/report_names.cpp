#include "report_names.h"

#include "anatomesh_io/dicom/folder.h"
#include "command_words.h"

namespace anatomesh {

namespace {

const std::string shown = "DICOM input";

// A whole word of the command line, or the value behind an option's equals sign.
void replace_word(std::string& command, const std::string& word, const std::string& by) {
    for (std::size_t at = command.find(word); at != std::string::npos; at = command.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        const bool is_whole = at > 0 && (command[at - 1] == ' ' || command[at - 1] == '=') &&
                              (end == command.size() || command[end] == ' ');
        if (is_whole) command.replace(at, word.size(), by);
    }
}

std::string without_slashes(std::string path) {
    while (path.size() > 1 && path.back() == '/') path.pop_back();
    return path;
}

// The input itself, or something in it: "FOLDER file 17", "FOLDER/name".
bool is_of(const std::string& place, const std::string& path) {
    return place.starts_with(path) &&
           (place.size() == path.size() || place[path.size()] == ' ' || place[path.size()] == '/');
}

}  // namespace

std::string shown_series(const std::string& series) {
    return series.find('.') == std::string::npos ? series : series_name(series);
}

void hide_dicom_names(ModelReport& report, const std::vector<std::string>& typed, const std::string& series) {
    for (InputReport& input : report.inputs) {
        if (!input.format.starts_with("DICOM")) continue;
        const std::string path = without_slashes(input.file);
        for (const std::string& word : typed)
            if (without_slashes(word) == path)
                replace_word(report.command, quoted_word(word), quoted_word(shown));
        for (Warning& warning : report.warnings)
            if (is_of(warning.place.file, path)) warning.place.file.replace(0, path.size(), shown);
        input.file = shown;
    }
    if (shown_series(series) != series)
        replace_word(report.command, quoted_word(series), shown_series(series));
}

}  // namespace anatomesh
