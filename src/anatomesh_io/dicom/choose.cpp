#include "anatomesh_io/dicom/choose.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "anatomesh_io/contour/raw_builder.h"

namespace anatomesh {

namespace {

Error choice_error(const char* code, std::string message, const std::string& file, std::string value,
                   std::string next_step) {
    return {ErrorKind::input,
            code,
            std::move(message),
            {file, {}, {}, {}, std::move(value)},
            std::move(next_step)};
}

const char* name_of_kind(DicomKind kind) {
    switch (kind) {
        case DicomKind::image:
            return "image";
        case DicomKind::rtstruct:
            return "RTSTRUCT";
        case DicomKind::segmentation:
            return "SEG";
        case DicomKind::other:
            break;
    }
    return "other object";
}

std::string list_of(const DicomFolder& folder, const std::vector<std::size_t>& candidates) {
    // A message lists no more candidates. [lines; >= 1; B]
    constexpr std::size_t most = 20;
    std::string list;
    for (std::size_t i = 0; i < std::min(candidates.size(), most); ++i)
        list += (i ? "; " : "") + describe_series(folder, folder.series[candidates[i]]);
    return list + (candidates.size() > most ? "; ..." : "");
}

bool is_usable(DicomKind kind) {
    return kind != DicomKind::other;
}

class Chooser {
  public:
    Chooser(const DicomFolder& folder, const ChooseOptions& options, RunContext& context)
        : folder_(folder), options_(options), context_(context) {}

    Result<DicomChoice> choose(const std::string& series) {
        ANATOMESH_TRY(const std::size_t chosen, series.empty() ? only_one() : named(series));
        const DicomSeries& found = folder_.series[chosen];
        DicomChoice choice;
        choice.kind = found.kind;
        choice.objects = found.objects;
        if (choice.kind == DicomKind::image) return choice;
        drop_copies(choice.objects);
        if (choice.objects.size() > 1) {
            std::vector<std::string> files;
            for (const std::uint32_t index : choice.objects) files.push_back(folder_.objects[index].label);
            return choice_error(
                "E-DCM-029", fmt::format("the series holds {} objects", choice.objects.size()), folder_.path,
                fmt::format("{}: {}", describe_series(folder_, found), fmt::join(files, ", ")),
                "give one of its files (--keep-patient-ids shows their names)");
        }
        const DicomObject& object = folder_.objects[choice.objects[0]];
        if (object.damage) return *object.damage;
        ANATOMESH_TRY(choice.images, images_of(object));
        return choice;
    }

  private:
    // Files of the same bytes are one object.
    void drop_copies(std::vector<std::uint32_t>& objects) {
        std::map<std::string, std::uint32_t> first;
        std::erase_if(objects, [&](std::uint32_t index) {
            const DicomObject& object = folder_.objects[index];
            const auto [kept, is_new] = first.emplace(object.sha256, index);
            if (!is_new)
                context_.warn({"W-DCM-003",
                               "the folder holds the file twice",
                               {object.label, "", "", "", folder_.objects[kept->second].label},
                               "it was read once"});
            return !is_new;
        });
    }

    std::vector<std::size_t> of_kind(std::initializer_list<DicomKind> kinds) const {
        std::vector<std::size_t> found;
        for (std::size_t i = 0; i < folder_.series.size(); ++i)
            if (std::find(kinds.begin(), kinds.end(), folder_.series[i].kind) != kinds.end())
                found.push_back(i);
        return found;
    }

    Result<std::size_t> only_one() const {
        const auto drawn = of_kind({DicomKind::rtstruct, DicomKind::segmentation});
        if (drawn.size() == 1) return drawn[0];
        const auto images = of_kind({DicomKind::image});
        const auto& candidates = drawn.empty() ? images : drawn;
        if (candidates.size() == 1) return candidates[0];
        if (!candidates.empty())
            return choice_error("E-DCM-029",
                                drawn.empty() ? "the folder holds several series of images"
                                              : "the folder holds several RTSTRUCT or SEG objects",
                                folder_.path, {},
                                "choose one with --series: " +
                                    list_of(folder_, of_kind({DicomKind::image, DicomKind::rtstruct,
                                                              DicomKind::segmentation})));
        if (!folder_.damaged.empty()) return folder_.damaged[0];
        return choice_error("E-DCM-031",
                            folder_.objects.empty()
                                ? "the folder holds no DICOM object"
                                : "none of the DICOM objects is an image, RTSTRUCT or SEG",
                            folder_.path, fmt::format("{} files", folder_.files),
                            "give a folder with a series, an RTSTRUCT or a SEG");
    }

    Result<std::size_t> named(const std::string& series) const {
        std::vector<std::size_t> found;
        for (std::size_t i = 0; i < folder_.series.size(); ++i)
            if (is_usable(folder_.series[i].kind) &&
                (folder_.series[i].uid == series || folder_.series[i].name == series))
                found.push_back(i);
        if (found.size() == 1) return found[0];
        const auto all = of_kind({DicomKind::image, DicomKind::rtstruct, DicomKind::segmentation});
        bool changed = false;
        return choice_error(
            "E-DCM-028",
            found.empty() ? "the folder holds no series of this UID or name"
                          : "several series of the folder have this name",
            folder_.path, valid_utf8(series.substr(0, 64), changed),
            all.empty() ? "the folder holds no series" : "the series are: " + list_of(folder_, all));
    }

    // The series that an object refers to, when it is there; else nothing.
    Result<std::vector<std::uint32_t>> images_of(const DicomObject& object) {
        std::vector<std::uint32_t> images, elsewhere;
        for (const DicomSeries& series : folder_.series) {
            if (series.kind != DicomKind::image) continue;
            const bool is_named = std::find(object.referenced_series.begin(), object.referenced_series.end(),
                                            series.uid) != object.referenced_series.end();
            const bool is_own = series.study == object.study &&
                                folder_.objects[series.objects[0]].patient_key == object.patient_key;
            std::vector<std::uint32_t>& list = is_own ? images : elsewhere;
            if (is_named) list.insert(list.end(), series.objects.begin(), series.objects.end());
        }
        // The same UID in another study counts only when it is not in the object's own.
        if (images.empty()) images = std::move(elsewhere);
        const bool has_others = !of_kind({DicomKind::image}).empty();
        if (images.empty() && !object.referenced_series.empty() && has_others) {
            if (options_.match_by_geometry) return images;
            return choice_error(
                "E-DCM-035",
                "the folder holds none of the images that the object refers to, but it holds others",
                object.label, list_of(folder_, of_kind({DicomKind::image})),
                "find the images by position with --match-by-geometry, or give the object alone");
        }
        for (const std::uint32_t index : images) {
            const DicomObject& image = folder_.objects[index];
            ANATOMESH_CHECK_STATUS(check_same(object, image));
        }
        check_all_are_here(object, images);
        return images;
    }

    Status check_same(const DicomObject& object, const DicomObject& image) {
        const bool other_frame = !image.frame_of_reference.empty() && !object.frame_of_reference.empty() &&
                                 image.frame_of_reference != object.frame_of_reference;
        if (other_frame && !options_.ignore_frame_of_reference)
            return choice_error(
                "E-DCM-032",
                "the contours and their images have different frames of reference, and no transform between "
                "them is known",
                object.label, image.label,
                "give the object alone, or use both as they are with --ignore-frame-of-reference");
        const bool other_patient = image.patient_key != object.patient_key || image.study != object.study;
        if (other_patient && !options_.ignore_patient)
            return choice_error("E-DCM-033", "the object and its images are of different patients or studies",
                                object.label, image.label,
                                "give the object alone, or use both as they are with --ignore-patient");
        if ((other_frame || other_patient) && !warned_)
            context_.warn({"W-DCM-022",
                           other_frame ? "the object and its images have different frames of reference"
                                       : "the object and its images are of different patients or studies",
                           {object.label, {}, {}, {}, image.label},
                           "they were used together, because the command allows it"});
        warned_ = warned_ || other_frame || other_patient;
        return Nothing{};
    }

    void check_all_are_here(const DicomObject& object, const std::vector<std::uint32_t>& images) {
        std::set<std::string> there;
        for (const std::uint32_t index : images) there.insert(folder_.objects[index].sop_instance);
        std::size_t absent = 0;
        for (const std::string& instance : object.referenced_instances) absent += !there.contains(instance);
        if (absent == 0) return;
        context_.warn({"W-DCM-018",
                       fmt::format("{} of {} images that the object refers to are not in what was given",
                                   absent, object.referenced_instances.size()),
                       {object.label, {}, {}, {}, {}},
                       images.empty()
                           ? "it was read without comparing it with them; give a folder that holds both to "
                             "compare them"
                           : "it was compared with the images that are there"});
    }

    const DicomFolder& folder_;
    const ChooseOptions& options_;
    RunContext& context_;
    bool warned_ = false;
};

}  // namespace

std::string describe_series(const DicomFolder& folder, const DicomSeries& series) {
    const DicomObject& first = folder.objects[series.objects[0]];
    bool changed = false;
    const std::string modality = valid_utf8(first.modality.substr(0, 16), changed);
    if (series.kind != DicomKind::image)
        return fmt::format("{}: {}", series.name,
                           series.kind == DicomKind::other ? modality : name_of_kind(series.kind));
    std::uint64_t frames = 0;
    for (const std::uint32_t index : series.objects) frames += folder.objects[index].frames;
    return fmt::format("{}: {}, {} images of {} x {}", series.name, modality, frames, first.columns,
                       first.rows);
}

Result<DicomChoice> choose_dicom(const DicomFolder& folder, const std::string& series, RunContext& context,
                                 const ChooseOptions& options) {
    return Chooser(folder, options, context).choose(series);
}

}  // namespace anatomesh
