#include "anatomesh_io/dicom/folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <tuple>
#include <utility>

#include "anatomesh_io/dicom/data_set.h"
#include "anatomesh_io/dicom/sha256.h"
#include "anatomesh_io/dicom/tags.h"
#include "anatomesh_io/file/byte_reader.h"

namespace anatomesh {

namespace fs = std::filesystem;

namespace {

constexpr const char* media_directory = "1.2.840.10008.1.3.10";

Error too_many(const std::string& path, const char* what, std::uint64_t most) {
    return {ErrorKind::limit,
            "E-DCM-030",
            fmt::format("the folder holds more than {} {}", most, what),
            {path, {}, {}, {}, {}},
            "give the folder of one study"};
}

// The regular files below a folder, in the order of their paths.
Result<std::vector<std::string>> files_below(const std::string& path, const DicomFolderOptions& options) {
    std::vector<std::string> files;
    std::error_code error;
    fs::recursive_directory_iterator at(path, fs::directory_options::skip_permission_denied, error), end;
    if (error)
        return Error{ErrorKind::file,
                     "E-INP-002",
                     "the folder cannot be read",
                     {path, {}, {}, {}, {}},
                     "check the permissions of the folder"};
    for (; at != end; at.increment(error)) {
        if (error) break;
        std::error_code ignored;
        if (!at->is_regular_file(ignored)) continue;
        if (files.size() >= options.max_files) return too_many(path, "files", options.max_files);
        files.push_back(at->path().string());
    }
    std::sort(files.begin(), files.end());
    return files;
}

// A first look: whether a file may be DICOM at all.
bool may_be_dicom(std::span<const std::byte> start) {
    const std::string_view text = as_text(start);
    if (is_dicom(text)) return true;
    if (text.size() < 8) return false;
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const bool little = (byte(0) == 8 || byte(0) == 2) && byte(1) == 0 && byte(2) <= 0x70 && byte(3) == 0;
    const bool big = byte(0) == 0 && byte(1) == 8 && byte(2) == 0 && byte(3) <= 0x70;
    return little || big;
}

class Scanner {
  public:
    Scanner(const std::string& path, const DicomFolderOptions& options, RunContext& context)
        : options_(options), context_(context) {
        folder_.path = path;
    }

    Result<DicomFolder> run() {
        std::error_code error;
        if (!fs::is_directory(folder_.path, error)) {
            ANATOMESH_CHECK_STATUS(look_at(folder_.path, folder_.path));
            folder_.files = 1;
        } else {
            ANATOMESH_TRY(const auto files, files_below(folder_.path, options_));
            folder_.files = files.size();
            for (std::size_t i = 0; i < files.size(); ++i) {
                if (context_.cancelled()) return cancelled_error();
                context_.report("read", static_cast<double>(i) / static_cast<double>(files.size()));
                const std::string label =
                    options_.keep_names ? files[i] : fmt::format("{} file {}", folder_.path, i + 1);
                ANATOMESH_CHECK_STATUS(look_at(files[i], label));
                if (folder_.objects.size() > options_.max_objects)
                    return too_many(folder_.path, "DICOM objects", options_.max_objects);
            }
        }
        sort();
        gather_series();
        warn();
        return std::move(folder_);
    }

  private:
    Status look_at(const std::string& path, const std::string& label) {
        const auto start = read_input_start(path, 4096);
        if (!start.ok() || !may_be_dicom(start.value())) {
            ++folder_.skipped;
            return Nothing{};
        }
        auto file = read_input_file(path, options_.limits);
        if (!file.ok()) {
            // Its name must not get out.
            Error error = file.error();
            error.place.file = label;
            if (error.code == "E-INP-007" || error.kind == ErrorKind::limit) return error;
            ++folder_.skipped;
            return Nothing{};
        }
        const std::string_view bytes = as_text(file.value().bytes());
        DataSet partial;
        const auto set = DataSet::parse(bytes, label, &partial);
        if (!set.ok() && set.error().code == "E-DCL-001") {
            ++folder_.skipped;
            return Nothing{};
        }
        const DataSet& known = set.ok() ? set.value() : partial;
        if (is_directory_of_media(known)) {
            ++folder_.skipped;
            return Nothing{};
        }
        DicomObject object = describe_object(known, path, label, options_.frames);
        object.bytes = bytes.size();
        object.sha256 = file.value().sha256();
        if (!set.ok()) {
            if (object.series.empty()) {
                folder_.damaged.push_back(set.error());
                return Nothing{};
            }
            object.damage = set.error();
            // What it would have been is not known when the pixels are what is cut off.
            if (object.kind == DicomKind::other) object.kind = DicomKind::image;
            object.image_warnings.clear();
        } else {
            note_syntax(set.value(), object);
        }
        folder_.objects.push_back(std::move(object));
        return Nothing{};
    }

    static bool is_directory_of_media(const DataSet& set) {
        return set.root().text(tags::sop_class) == media_directory || set.root().find({0x0004, 0x1220});
    }

    static void note_syntax(const DataSet& set, DicomObject& object) {
        RunContext notes;
        warn_of_guess(set.layout(), set.name(), notes);
        object.image_warnings.insert(object.image_warnings.begin(), notes.warnings.begin(),
                                     notes.warnings.end());
    }

    void sort() {
        const auto key = [](const DicomObject& o) {
            return std::tie(o.patient_key, o.study, o.series, o.kind, o.sop_instance, o.sha256, o.label);
        };
        std::sort(folder_.objects.begin(), folder_.objects.end(),
                  [&](const DicomObject& a, const DicomObject& b) { return key(a) < key(b); });
    }

    void gather_series() {
        const DicomObject* before = nullptr;
        for (std::uint32_t i = 0; i < folder_.objects.size(); ++i) {
            const DicomObject& object = folder_.objects[i];
            const bool is_new = !before || before->patient_key != object.patient_key ||
                                before->study != object.study || before->series != object.series ||
                                before->kind != object.kind;
            if (is_new)
                folder_.series.push_back({object.study,
                                          object.series,
                                          options_.keep_names ? object.series : series_name(object.series),
                                          object.kind,
                                          {}});
            folder_.series.back().objects.push_back(i);
            before = &object;
        }
        tell_apart();
    }

    // One UID in several studies, of several patients or for several kinds of objects: each gets a name of
    // its own, by which --series can choose it.
    void tell_apart() {
        std::map<std::string, std::vector<DicomSeries*>> by_name;
        for (DicomSeries& series : folder_.series)
            if (series.kind != DicomKind::other) by_name[series.name].push_back(&series);
        for (const auto& [name, all] : by_name) {
            if (all.size() < 2) continue;
            for (DicomSeries* series : all) {
                const std::string& patient = folder_.objects[series->objects[0]].patient_key;
                const int kind = static_cast<int>(series->kind);
                series->name += "-" + series_name(fmt::format("{}\n{}\n{}", patient, series->study, kind));
            }
        }
    }

    void warn() {
        if (folder_.skipped > 0 && folder_.files > 1)
            context_.warn({"W-DCM-001",
                           fmt::format("{} of {} files in the folder are no DICOM objects", folder_.skipped,
                                       folder_.files),
                           {folder_.path, {}, {}, {}, {}},
                           "they were ignored"});
        if (!folder_.damaged.empty() && folder_.files > 1)
            context_.warn({"W-DCM-002",
                           fmt::format("{} DICOM files are so damaged that their series is unknown",
                                       folder_.damaged.size()),
                           {folder_.damaged[0].place.file, {}, {}, {}, folder_.damaged[0].message},
                           "they were ignored"});
    }

    const DicomFolderOptions& options_;
    RunContext& context_;
    DicomFolder folder_;
};

}  // namespace

std::string series_name(const std::string& uid) {
    return sha256_text(uid).substr(0, 8);
}

Result<DicomFolder> read_dicom_folder(const std::string& path, const DicomFolderOptions& options,
                                      RunContext& context) {
    return Scanner(path, options, context).run();
}

}  // namespace anatomesh
