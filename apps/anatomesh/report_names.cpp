#include "report_names.h"

#include <filesystem>
#include <system_error>

#include "anatomesh_io/dicom/folder.h"
#include "command_words.h"

namespace anatomesh {

namespace {

const std::string input_shown_as = "DICOM input";

std::string without_slashes(std::string path) {
    while (path.size() > 1 && path.back() == '/') path.pop_back();
    return path;
}

// Where the value begins in a word, which may be "--option=value".
std::size_t value_of(const std::string& word) {
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
    return equals == std::string::npos ? 0 : equals + 1;
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

void hide_dicom_names(ModelReport& report, std::vector<std::string> words, const std::string& series) {
    bool any = false;
    for (InputReport& input : report.provenance.inputs) {
        if (!input.format.starts_with("DICOM")) continue;
        any = true;
        const std::string path = without_slashes(input.file);
        for (std::string& word : words) {
            const std::size_t value = value_of(word);
            if (without_slashes(word.substr(value)) == path)
                word.replace(value, std::string::npos, input_shown_as);
        }
        for (Warning& warning : report.warnings)
            if (is_of(warning.place.file, path)) warning.place.file.replace(0, path.size(), input_shown_as);
        input.file = input_shown_as;
    }
    if (!any) return;
    for (std::string& word : words) {
        const std::size_t value = value_of(word);
        std::error_code error;
        const std::filesystem::path path(word.substr(value));
        if (path == series)
            word.replace(value, std::string::npos, shown_series(series));
        else if (path.has_filename() && path.has_parent_path() &&
                 std::filesystem::is_directory(path.parent_path(), error))
            word.replace(value, std::string::npos, path.filename().string());
    }
    report.provenance.command = quoted_command(words);
}

}  // namespace anatomesh
